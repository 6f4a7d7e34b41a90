//! Plots of the documentation pages: lines and points over two axes, as SVG.

use crate::Failure;
use plotters::coord::combinators::WithKeyPoints;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::path::Path;

/// Eight colours that colour-blind readers distinguish (Okabe and Ito), with a darker yellow.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(150, 140, 20),
    RGBColor(90, 90, 90),
];
/// Width and height of a plot, pixels.
const PLOT_SIZE: (u32, u32) = (860, 560);
/// Width of the labels of the vertical axis, pixels.
const Y_LABEL_WIDTH: u32 = 78;
const FONT: &str = "Helvetica, Arial, sans-serif";

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesMark {
    /// A line with a dot at each point.
    LineWithPoints,
    /// A dashed line, for bounds and reference slopes.
    Dashed,
    /// Dots only.
    Dots,
    /// A line without dots.
    Line,
}

/// A series of points. A series with an empty name is not in the legend.
#[derive(Clone, Debug)]
pub struct PlotSeries {
    /// Its name in the legend.
    pub name: String,
    /// Its points; values that are not positive are left out on a logarithmic axis.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: SeriesMark,
    /// Its colour, an index into the palette.
    pub colour: usize,
}

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// Linear.
    Linear,
    /// Logarithmic, base ten.
    Logarithmic,
}

use AxisScale::{Linear, Logarithmic};

/// Linear scales on both axes.
pub const LINEAR: [AxisScale; 2] = [Linear, Linear];
/// A linear horizontal and a logarithmic vertical axis.
pub const LINEAR_LOG: [AxisScale; 2] = [Linear, Logarithmic];
/// Logarithmic scales on both axes.
pub const LOG_LOG: [AxisScale; 2] = [Logarithmic, Logarithmic];

impl AxisScale {
    /// True if the value can be drawn.
    fn can_draw(self, v: f64) -> bool {
        self == Linear || v > 0.0
    }
}

/// A plot: titles, axes, series.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Quantity along the horizontal axis, with its unit.
    pub x: String,
    /// Quantity along the vertical axis, with its unit.
    pub y: String,
    /// Scales of the horizontal and the vertical axis.
    pub scales: [AxisScale; 2],
    /// Smallest and largest value on the vertical axis; `None`: from the data.
    pub range: Option<(f64, f64)>,
    /// Position of the legend.
    pub legend: LegendPlacement,
    /// The series.
    pub series: Vec<PlotSeries>,
}

/// Position of a legend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LegendPlacement {
    /// For curves that fall.
    #[default]
    UpperRight,
    /// For curves that rise.
    LowerRight,
    /// Beside the plot, for many curves.
    Beside,
}

/// Width of a legend beside the plot, pixels.
const LEGEND_WIDTH: u32 = 230;

impl Plot {
    /// An empty plot.
    pub fn new(title: &str, x: &str, y: &str, scales: [AxisScale; 2]) -> Plot {
        Plot {
            title: title.into(),
            x: x.into(),
            y: y.into(),
            scales,
            range: None,
            legend: LegendPlacement::default(),
            series: Vec::new(),
        }
    }

    /// Adds a series.
    pub fn add(&mut self, name: &str, mark: SeriesMark, colour: usize, points: Vec<(f64, f64)>) -> &mut Plot {
        self.series.push(PlotSeries { name: name.into(), points, mark, colour });
        self
    }

    /// Writes the plot as SVG.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|e| Failure::in_file(path, e))?;
        zonal_io::output::write_bytes(path, svg.as_bytes())?;
        Ok(())
    }

    /// The plot as text of an SVG file; `None` if it cannot be drawn.
    #[must_use]
    pub fn svg(&self) -> Option<String> {
        let mut svg = String::new();
        self.draw(&mut svg).ok().map(|()| svg)
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let is_drawable = |&(x, y): &(f64, f64)| {
            x.is_finite() && y.is_finite() && self.scales[0].can_draw(x) && self.scales[1].can_draw(y)
        };
        let mut plot = self.clone();
        plot.series.iter_mut().for_each(|s| s.points.retain(is_drawable));
        if let Some((low, high)) = self.range {
            plot.series.iter_mut().for_each(|s| s.points.retain(|p| (low..=high).contains(&p.1)));
        }
        let all = || plot.series.iter().flat_map(|s| s.points.iter());
        let (x, y) =
            (axis_range(all().map(|p| p.0), self.scales[0]), axis_range(all().map(|p| p.1), self.scales[1]));
        let y = self.range.map_or(y, |(a, b)| a..b);
        let area = SVGBackend::with_string(svg, PLOT_SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        match self.scales {
            [Linear, Linear] => plot.draw_chart(&area, x, y)?,
            [Logarithmic, Linear] => plot.draw_chart(&area, logarithmic_axis(x), y)?,
            [Linear, Logarithmic] => plot.draw_chart(&area, x, logarithmic_axis(y))?,
            [Logarithmic, Logarithmic] => plot.draw_chart(&area, logarithmic_axis(x), logarithmic_axis(y))?,
        }
        area.present()?;
        Ok(())
    }

    /// Draws the legend to the right of the plot.
    fn draw_legend_beside(
        &self,
        area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
        text: &TextStyle,
    ) -> Result<(), Box<dyn std::error::Error>> {
        const LEGEND_LINE_HEIGHT: i32 = 22;
        let left = (PLOT_SIZE.0 - LEGEND_WIDTH) as i32 + 14;
        for (k, s) in self.series.iter().filter(|s| !s.name.is_empty()).enumerate() {
            let y = 52 + LEGEND_LINE_HEIGHT * k as i32;
            area.draw(&legend_sample(left, y, s.mark, COLOURS[s.colour % COLOURS.len()]))?;
            area.draw(&Text::new(s.name.clone(), (left + 28, y - 7), text.clone()))?;
        }
        Ok(())
    }

    /// Draws title, axes, series and legend.
    fn draw_chart<X, Y>(
        &self,
        area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
        x: X,
        y: Y,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        Y: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
        X::CoordDescType: plotters::coord::ranged1d::ValueFormatter<f64>,
        Y::CoordDescType: plotters::coord::ranged1d::ValueFormatter<f64>,
    {
        let title = (FONT, 19).into_font().color(&RGBColor(30, 30, 30));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, title)
            .margin(14)
            .margin_right(if self.legend == LegendPlacement::Beside { LEGEND_WIDTH } else { 24 })
            .x_label_area_size(52)
            .y_label_area_size(Y_LABEL_WIDTH)
            .build_cartesian_2d(x, y)?;
        let label = (FONT, 14).into_font().color(&RGBColor(60, 60, 60));
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .axis_desc_style(label.clone())
            .label_style(label.clone())
            .x_label_formatter(&|v| tick_label(*v, self.scales[0]))
            .y_label_formatter(&|v| tick_label(*v, self.scales[1]))
            .bold_line_style(RGBColor(222, 222, 222))
            .light_line_style(RGBColor(243, 243, 243))
            .axis_style(RGBColor(120, 120, 120))
            .draw()?;
        self.draw_series(&mut chart)?;
        let text = (FONT, 13).into_font().color(&RGBColor(40, 40, 40)).pos(Pos::new(HPos::Left, VPos::Top));
        let corner = match self.legend {
            LegendPlacement::UpperRight => SeriesLabelPosition::UpperRight,
            LegendPlacement::LowerRight => SeriesLabelPosition::LowerRight,
            LegendPlacement::Beside => return self.draw_legend_beside(area, &text),
        };
        chart
            .configure_series_labels()
            .position(corner)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(205, 205, 205))
            .label_font(text)
            .draw()?;
        Ok(())
    }

    /// Draws the series with their samples for the legend.
    fn draw_series<X, Y>(
        &self,
        chart: &mut ChartContext<SVGBackend<'_>, Cartesian2d<X, Y>>,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        for s in &self.series {
            let colour = COLOURS[s.colour % COLOURS.len()];
            let points = || s.points.iter().copied();
            let drawn = match s.mark {
                SeriesMark::LineWithPoints => {
                    chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?;
                    chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?
                }
                SeriesMark::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points(), 6, 4, colour.stroke_width(2)))?
                }
                SeriesMark::Line => chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?,
                SeriesMark::Dots => {
                    chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?
                }
            };
            if s.name.is_empty() {
                continue;
            }
            drawn.label(&s.name);
            let mark = s.mark;
            drawn.legend(move |(x, y)| legend_sample(x, y, mark, colour));
        }
        Ok(())
    }
}

/// The sample of a series in the legend: a line, a short line for a dashed series, a dot for dots.
fn legend_sample(x: i32, y: i32, mark: SeriesMark, colour: RGBColor) -> PathElement<(i32, i32)> {
    match mark {
        SeriesMark::LineWithPoints | SeriesMark::Line => {
            PathElement::new(vec![(x, y), (x + 20, y)], colour.stroke_width(3))
        }
        SeriesMark::Dashed => PathElement::new(vec![(x, y), (x + 9, y)], colour.stroke_width(2)),
        SeriesMark::Dots => PathElement::new(vec![(x + 7, y), (x + 13, y)], colour.stroke_width(6)),
    }
}

/// The range of an axis: that of the values with a margin.
fn axis_range(values: impl Iterator<Item = f64> + Clone, scale: AxisScale) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if !(low.is_finite() && high.is_finite()) {
        return 0.1..1.0;
    }
    if scale == Logarithmic {
        let margin = (high / low).powf(0.04).max(1.1);
        return low / margin..high * margin;
    }
    let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
    low - margin..high + margin
}

/// A logarithmic axis with ticks at the powers of ten, and between them if these are few.
fn logarithmic_axis(range: Range<f64>) -> WithKeyPoints<LogCoord<f64>> {
    let ticks = ticks(&range);
    LogCoord::from(range.log_scale()).with_key_points(ticks)
}

fn ticks(range: &Range<f64>) -> Vec<f64> {
    let decades = (range.end / range.start).log10();
    let digits: &[u32] = match decades {
        d if d < 0.7 => &[10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90],
        d if d < 1.5 => &[10, 20, 30, 50, 70],
        d if d < 3.0 => &[10, 20, 50],
        _ => &[10],
    };
    let (low, high) = (range.start.log10().floor() as i32, range.end.log10().ceil() as i32);
    // More than twelve powers of ten: every second, third, …
    let step = ((high - low) / 12 + 1) as usize;
    let power = |p: i32, d: &u32| format!("{d}e{}", p - 1).parse().unwrap_or(f64::NAN);
    let all = (low..=high).filter(|p| p.rem_euclid(step as i32) == 0);
    all.flat_map(|p| digits.iter().map(move |d| power(p, d))).filter(|t| range.contains(t)).collect()
}

/// Label of a tick: a power of ten on a logarithmic axis, a decimal number elsewhere.
#[must_use]
pub fn tick_label(v: f64, scale: AxisScale) -> String {
    let magnitude = v.abs();
    if scale == Logarithmic && !(1e-2..1e4).contains(&magnitude) {
        return format!("{v:e}");
    }
    if magnitude != 0.0 && !(1e-3..1e5).contains(&magnitude) {
        return format!("{v:.1e}");
    }
    let text = format!("{v:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plot_draws_finite_points_only() {
        let mut p = Plot::new("title", "x in m", "y", LINEAR_LOG);
        p.add(
            "seen",
            SeriesMark::LineWithPoints,
            0,
            vec![(0.0, 1.0), (1.0, 1e-3), (2.0, 0.0), (3.0, f64::NAN)],
        );
        p.add("bound", SeriesMark::Dashed, 1, vec![(0.0, 2.0), (1.0, 2e-3)]);
        let mut svg = String::new();
        p.draw(&mut svg).unwrap();
        assert!(
            svg.contains("title") && svg.contains("seen") && svg.contains("bound") && svg.contains("x in m")
        );
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(&(0.9..120.0)), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!(ticks(&(3.0..6.1)), [3.0, 4.0, 5.0, 6.0]);
        assert!(ticks(&(1e-16..10.0)).len() <= 12);
    }

    #[test]
    fn labels_have_no_trailing_zeros() {
        assert_eq!(tick_label(0.5, Linear), "0.5");
        assert_eq!(tick_label(20.0, Linear), "20");
        assert_eq!(tick_label(1e-6, Logarithmic), "1e-6");
        assert_eq!(tick_label(0.0, Linear), "0");
    }
}
