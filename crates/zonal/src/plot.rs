//! Plots of the documentation pages: lines and points over two axes, as SVG.

use crate::Failure;
use plotters::coord::combinators::WithKeyPoints;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::path::Path;

/// Eight colours that colour-blind readers tell apart (Okabe and Ito), the yellow darkened.
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
const SIZE: (u32, u32) = (860, 560);
/// Pixels of the labels along the vertical axis.
const LABELS: u32 = 78;
const FONT: &str = "Helvetica, Arial, sans-serif";

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line with a dot at each point.
    Line,
    /// A dashed line: bounds and guides.
    Dashed,
    /// Dots only.
    Dots,
    /// A line without dots.
    Plain,
}

/// Points with a name in the legend; an empty name has none.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points; on a logarithmic axis those that are not positive are left out.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
    /// Its colour, an index into the palette.
    pub colour: usize,
}

/// A plot: titles, axes, series.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What is to be seen.
    pub title: String,
    /// Quantity along the horizontal axis, with its unit.
    pub x: String,
    /// Quantity along the vertical axis, with its unit.
    pub y: String,
    /// Logarithmic axes.
    pub log: (bool, bool),
    /// Least and largest value on the vertical axis, where the data shall not decide.
    pub range: Option<(f64, f64)>,
    /// Where the legend stands.
    pub legend: Legend,
    /// What is drawn.
    pub series: Vec<Series>,
}

/// The corner of a plot where its legend stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// For curves that fall.
    #[default]
    UpperRight,
    /// For curves that rise.
    LowerRight,
    /// Beside the plot, for many curves.
    Beside,
}

/// Pixels that a legend beside the plot takes.
const BESIDE: u32 = 230;

impl Plot {
    /// An empty plot.
    pub fn new(title: &str, x: &str, y: &str, log: (bool, bool)) -> Plot {
        Plot {
            title: title.into(),
            x: x.into(),
            y: y.into(),
            log,
            range: None,
            legend: Legend::default(),
            series: Vec::new(),
        }
    }

    /// Adds a series.
    pub fn add(&mut self, name: &str, mark: Mark, colour: usize, points: Vec<(f64, f64)>) -> &mut Plot {
        self.series.push(Series { name: name.into(), points, mark, colour });
        self
    }

    /// Writes the plot as SVG.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let mut svg = String::new();
        self.draw(&mut svg).map_err(|e| Failure::in_file(path, e))?;
        zonal_io::output::write_bytes(path, svg.as_bytes())?;
        Ok(())
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let seen = |&(x, y): &(f64, f64)| {
            x.is_finite() && y.is_finite() && (!self.log.0 || x > 0.0) && (!self.log.1 || y > 0.0)
        };
        let mut plot = self.clone();
        plot.series.iter_mut().for_each(|s| s.points.retain(seen));
        if let Some((low, high)) = self.range {
            plot.series.iter_mut().for_each(|s| s.points.retain(|p| (low..=high).contains(&p.1)));
        }
        let all = || plot.series.iter().flat_map(|s| s.points.iter());
        let (x, y) = (span(all().map(|p| p.0), self.log.0), span(all().map(|p| p.1), self.log.1));
        let y = self.range.map_or(y, |(a, b)| a..b);
        let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        match self.log {
            (false, false) => plot.chart(&area, x, y)?,
            (true, false) => plot.chart(&area, log(x), y)?,
            (false, true) => plot.chart(&area, x, log(y))?,
            (true, true) => plot.chart(&area, log(x), log(y))?,
        }
        area.present()?;
        Ok(())
    }

    /// The legend to the right of the plot.
    fn beside(
        &self,
        area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
        text: &TextStyle,
    ) -> Result<(), Box<dyn std::error::Error>> {
        const LINE: i32 = 22;
        let left = (SIZE.0 - BESIDE) as i32 + 14;
        for (k, s) in self.series.iter().filter(|s| !s.name.is_empty()).enumerate() {
            let y = 52 + LINE * k as i32;
            area.draw(&sample(left, y, s.mark, COLOURS[s.colour % COLOURS.len()]))?;
            area.draw(&Text::new(s.name.clone(), (left + 28, y - 7), text.clone()))?;
        }
        Ok(())
    }

    fn chart<X, Y>(
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
            .margin_right(if self.legend == Legend::Beside { BESIDE } else { 24 })
            .x_label_area_size(52)
            .y_label_area_size(LABELS)
            .build_cartesian_2d(x, y)?;
        let label = (FONT, 14).into_font().color(&RGBColor(60, 60, 60));
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .axis_desc_style(label.clone())
            .label_style(label.clone())
            .x_label_formatter(&|v| number(*v, self.log.0))
            .y_label_formatter(&|v| number(*v, self.log.1))
            .bold_line_style(RGBColor(222, 222, 222))
            .light_line_style(RGBColor(243, 243, 243))
            .axis_style(RGBColor(120, 120, 120))
            .draw()?;
        for s in &self.series {
            let colour = COLOURS[s.colour % COLOURS.len()];
            let points = || s.points.iter().copied();
            let drawn = match s.mark {
                Mark::Line => {
                    chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?;
                    chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?
                }
                Mark::Dashed => {
                    chart.draw_series(DashedLineSeries::new(points(), 6, 4, colour.stroke_width(2)))?
                }
                Mark::Plain => chart.draw_series(LineSeries::new(points(), colour.stroke_width(2)))?,
                Mark::Dots => chart.draw_series(points().map(|p| Circle::new(p, 3, colour.filled())))?,
            };
            if s.name.is_empty() {
                continue;
            }
            drawn.label(&s.name);
            let mark = s.mark;
            drawn.legend(move |(x, y)| sample(x, y, mark, colour));
        }
        let text = (FONT, 13).into_font().color(&RGBColor(40, 40, 40)).pos(Pos::new(HPos::Left, VPos::Top));
        let corner = match self.legend {
            Legend::UpperRight => SeriesLabelPosition::UpperRight,
            Legend::LowerRight => SeriesLabelPosition::LowerRight,
            Legend::Beside => return self.beside(area, &text),
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
}

/// The sample of a series in the legend: a stroke, a thin stroke for a dashed line, a spot for dots.
fn sample(x: i32, y: i32, mark: Mark, colour: RGBColor) -> PathElement<(i32, i32)> {
    match mark {
        Mark::Line | Mark::Plain => PathElement::new(vec![(x, y), (x + 20, y)], colour.stroke_width(3)),
        Mark::Dashed => PathElement::new(vec![(x, y), (x + 9, y)], colour.stroke_width(2)),
        Mark::Dots => PathElement::new(vec![(x + 7, y), (x + 13, y)], colour.stroke_width(6)),
    }
}

/// A range that holds the values with a little room.
fn span(values: impl Iterator<Item = f64> + Clone, log: bool) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if !(low.is_finite() && high.is_finite()) {
        return 0.1..1.0;
    }
    if log {
        let room = (high / low).powf(0.04).max(1.1);
        return low / room..high * room;
    }
    let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
    low - room..high + room
}

/// A logarithmic axis with ticks at the powers of ten, and between them where there are few.
fn log(range: Range<f64>) -> WithKeyPoints<LogCoord<f64>> {
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
    // More than a dozen powers of ten: every second, third …
    let step = ((high - low) / 12 + 1) as usize;
    let power = |p: i32, d: &u32| format!("{d}e{}", p - 1).parse().unwrap_or(f64::NAN);
    let all = (low..=high).filter(|p| p.rem_euclid(step as i32) == 0);
    all.flat_map(|p| digits.iter().map(move |d| power(p, d))).filter(|t| range.contains(t)).collect()
}

/// A label: powers of ten on a logarithmic axis, plain numbers elsewhere.
pub(crate) fn number(v: f64, log: bool) -> String {
    let magnitude = v.abs();
    if log && !(1e-2..1e4).contains(&magnitude) {
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
    fn a_plot_draws_what_is_in_it_and_no_more() {
        let mut p = Plot::new("title", "x in m", "y", (false, true));
        p.add("seen", Mark::Line, 0, vec![(0.0, 1.0), (1.0, 1e-3), (2.0, 0.0), (3.0, f64::NAN)]);
        p.add("bound", Mark::Dashed, 1, vec![(0.0, 2.0), (1.0, 2e-3)]);
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
    fn labels_are_short() {
        assert_eq!(number(0.5, false), "0.5");
        assert_eq!(number(20.0, false), "20");
        assert_eq!(number(1e-6, true), "1e-6");
        assert_eq!(number(0.0, false), "0");
    }
}
