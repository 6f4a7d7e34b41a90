//! Entry points of the renderer: pictures of one solution by one or several cameras.
//!
//! A pixel is the mean radiance over its rays, L = (1/n) Σ_i L(o_i, d_i), at the positions of [`subpixel`]; with `samples` = 0 and
//! a pinhole the rays are placed by [`AdaptiveSampler`]. Bands with wavelengths are drawn block by block and joined by their colours (`spectral_colour`). Cost: rays × (ray–scene intersection + segments of the medium × lights).

pub(crate) mod adaptive_sampling;
pub(crate) mod camera;
pub(crate) mod item_buffer;

use crate::image::spectral_colour::{block_colours, colour_of};
use crate::image::{Image, pixels_of_rows, to_pixel};
use crate::integrator::node_lattice::Viewpoint;
use crate::integrator::radiance::{DirectLightAccuracy, Integrator};
use crate::integrator::ray_sampler::{RaySampler, pixel_shift};
use crate::integrator::sky_field::StoredSkies;
use crate::options::{LENS_RAYS, RenderOptions, SKY_RAYS};
use crate::picture::adaptive_sampling::AdaptiveSampler;
use crate::picture::camera::{PerspectiveCamera, subpixel};
use crate::view_ray::ViewRay;
use zonal_scene::{Bands, Camera, Diagnostic, EvenExtension, Lens, Progress, Scene, Solution};
use zonal_transport::Transport;

/// Renders the view of a camera. The same bits for any number of threads.
///
/// A black wall that emits 1 W/m² has the radiance 1/π, attenuated by two metres of a cold medium of 0.5 1/m:
///
/// ```
/// use zonal_render::{RenderOptions, render};
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Camera, Facet, Fields, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution,
/// #     Surface, VoxelGrid,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(vec3(-9.0, 2.0, -9.0), vec3(18.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0));
/// # let wall_facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
/// # let mut grid = VoxelGrid::new(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), [2, 2, 2]).unwrap();
/// # (0..8).for_each(|i| grid.set(i, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![wall_facet],
/// #     voxel_grid: Some(grid.seal().unwrap()),
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let emission: Vec<Bands> = (0..zones.len()).map(|i| zones.emission(i)).collect();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (emission, zero.clone());
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// let camera = Camera::look_at([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let options = RenderOptions { width: 8, height: 6, ..RenderOptions::default() };
/// let image = render(&solution, &camera, &options, &NoProgress);
/// assert_eq!(image.pixels.len(), 48);
/// let narrow = Camera { fov: 1.0, ..camera };
/// let radiance = render(&solution, &narrow, &options, &NoProgress).pixels[20][0] as f64;
/// let expected = (-0.5f64 * 2.0).exp() / std::f64::consts::PI;
/// assert!((radiance / expected - 1.0).abs() < 1e-3);
/// ```
pub fn render(
    solution: &Solution,
    camera: &Camera,
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Image {
    let mut out = None;
    let cameras = std::slice::from_ref(camera);
    let Ok(()) = render_each(solution, cameras, options, progress, |_, image| {
        out = Some(image);
        Ok::<(), std::convert::Infallible>(())
    });
    out.unwrap_or(Image { width: 0, height: 0, pixels: Vec::new() })
}

/// Renders the view of each camera and passes its index and picture to `take`. The data of the solution are prepared once; the
/// pictures are those of [`render`].
///
/// # Errors
/// The first error of `take`; the remaining cameras are not rendered.
pub fn render_each<E>(
    solution: &Solution,
    cameras: &[Camera],
    options: &RenderOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(usize, Image) -> Result<(), E>,
) -> Result<(), E> {
    let colours = block_colours(solution.scene.bands());
    // Bands without wavelengths are drawn as red, green and blue, and there is one block of them.
    let drawn = if colours.is_some() { solution.blocks().count() } else { 1 };
    let extended: Vec<Option<Solution>> = solution
        .blocks()
        .take(drawn)
        .map(|s| even_extension(&s.scene).map(|e| e.extended_solution(s)))
        .collect();
    let blocks: Vec<&Solution> =
        solution.blocks().zip(&extended).map(|(s, extended)| extended.as_ref().unwrap_or(s)).collect();
    let transports: Vec<Transport> = blocks.iter().map(|s| Transport::new(&s.scene)).collect();
    let accuracy =
        if options.samples == 0 { DirectLightAccuracy::Clustered } else { DirectLightAccuracy::PerFacet };
    let of_block = |(s, transport)| {
        let integrator = Integrator::new(s, transport).with_gather(options.gather).with_accuracy(accuracy);
        if samples_skies(options) { integrator } else { integrator.with_skies_of_zones() }
    };
    let mut integrators: Vec<Integrator> = blocks.iter().copied().zip(&transports).map(of_block).collect();
    for (i, camera) in cameras.iter().enumerate() {
        let focus = camera.lens.focus.or_else(|| focus_distance(&transports[0], camera));
        let camera = Camera { lens: Lens { focus, ..camera.lens }, ..camera.clone() };
        let pixel_angle = camera.fov.to_radians() / options.width.max(1) as f64;
        let viewpoint = Viewpoint { origin: camera.origin, pixel_angle };
        let camera = PerspectiveCamera::new(&camera, options.width, options.height);
        let mut images = integrators.iter_mut().map(|integrator| {
            integrator.look_from(viewpoint);
            let mut image = render_pixels(integrator, &camera, options, progress);
            // Clamp negative radiances, which linear fields in optically thick voxels may leave.
            image.pixels.iter_mut().flatten().filter(|x| **x < 0.0).for_each(|x| *x = 0.0);
            image
        });
        let image = match &colours {
            Some(colours) => join_bands(images, colours, options),
            None => images.next().unwrap_or(Image { width: 0, height: 0, pixels: Vec::new() }),
        };
        take(i, image)?;
    }
    Ok(())
}

/// True if skies in the medium are sampled along every ray; false if the means over the voxel zones give their light.
fn samples_skies(options: &RenderOptions) -> bool {
    options.samples >= SKY_RAYS
}

/// The warning of a picture whose sky light in the medium is sampled by few directions of each ray: that of a solution without it apart.
#[must_use]
pub fn sky_noise(solution: &Solution, options: &RenderOptions) -> Option<Diagnostic> {
    let grid = solution.scene.voxel_grid()?;
    let sky = solution.scene.lights().iter().find(|l| l.fills_sphere())?;
    let scatters = |c: usize| (grid.extinction(c) * grid.albedo(c)).any(|x| x > 0.0);
    if samples_skies(options) || StoredSkies::of(solution).is_some() || !(0..grid.len()).any(scatters) {
        return None;
    }
    let text = format!(
        "light '{}': sky light in a scattering medium is sampled, since the solution has it in one sum with other lights; single pixels have noise of 10 % and more: solve with --light-groups each, or render with --samples 64",
        sky.name(solution.scene.surfaces())
    );
    Some(Diagnostic::warning("sky-noise", text))
}

/// The picture in linear sRGB from those of the blocks of bands, whose pixels are radiances of bands.
fn join_bands(
    images: impl Iterator<Item = Image>,
    colours: &[[[f64; 3]; 3]],
    options: &RenderOptions,
) -> Image {
    let (width, height) = (options.width, options.height);
    let mut sum = vec![[0.0f64; 3]; width * height];
    for (image, colours) in images.zip(colours) {
        for (sum, pixel) in sum.iter_mut().zip(&image.pixels) {
            let own = colour_of(colours, Bands::from_rgb(pixel.map(f64::from)));
            (0..3).for_each(|c| sum[c] += own[c]);
        }
    }
    Image { width, height, pixels: sum.into_iter().map(|x| to_pixel(Bands::from_rgb(x))).collect() }
}

/// Distance, m, to the first surface or pane in the middle of each camera's picture; `None` where there is none.
///
/// ```
/// use zonal_render::focus_distances;
/// # use zonal_math::{Vec3, vec3};
/// # use zonal_scene::{
/// #     Bands, Camera, Facet, Fields, NoProgress, Plate, Report, Scene, SceneParts, Sides, Solution,
/// #     Surface, VoxelGrid,
/// # };
/// # use zonal_transport::{Transport, build_zones};
/// # let wall = Surface {
/// #     name: "wall".into(),
/// #     reflectance: Bands::ZERO,
/// #     emission: Bands::ONE,
/// #     sides: Sides::Both,
/// #     ..Surface::default()
/// # };
/// # let plate = Plate::parallelogram(vec3(-9.0, 2.0, -9.0), vec3(18.0, 0.0, 0.0), vec3(0.0, 0.0, 18.0));
/// # let wall_facet = Facet { surface: 0, plate, uv: [[0.0; 2]; 3] };
/// # let mut grid = VoxelGrid::new(vec3(-1.0, 0.0, -1.0), vec3(1.0, 1.0, 1.0), [2, 2, 2]).unwrap();
/// # (0..8).for_each(|i| grid.set(i, Bands::splat(0.5), Bands::ZERO, Bands::ZERO, Bands::ZERO));
/// # let scene = Scene::new(SceneParts {
/// #     surfaces: vec![wall],
/// #     facets: vec![wall_facet],
/// #     voxel_grid: Some(grid.seal().unwrap()),
/// #     ..SceneParts::default()
/// # })
/// # .unwrap();
/// # let zones = build_zones(&scene, &Transport::new(&scene)).unwrap();
/// # let emission: Vec<Bands> = (0..zones.len()).map(|i| zones.emission(i)).collect();
/// # let zero = vec![Bands::ZERO; zones.len()];
/// # let mut fields = Fields::default();
/// # (fields.radiosity, fields.incident) = (emission, zero.clone());
/// # (fields.direct, fields.error) = (zero.clone(), zero);
/// # let (groups, report) = (Vec::new(), Report::default());
/// # let (scene_hash, version) = (String::new(), String::new());
/// # let solution = Solution { scene, zones, fields, groups, report, further_blocks: Vec::new(), scene_hash, version };
/// let camera = Camera::look_at([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// let away = Camera { target: vec3(0.0, -1.0, 0.0), ..camera.clone() };
/// let distances = focus_distances(&solution, &[camera, away]);
/// assert!((distances[0].unwrap() - 2.0).abs() < 1e-9);
/// assert_eq!(distances[1], None);
/// ```
pub fn focus_distances(solution: &Solution, cameras: &[Camera]) -> Vec<Option<f64>> {
    let extension = even_extension(&solution.scene);
    let transport = Transport::new(extension.as_ref().map_or(&solution.scene, |e| &e.scene));
    cameras.iter().map(|c| focus_distance(&transport, c)).collect()
}

/// The even extension of a scene with symmetry planes, in which rays go straight where the symmetry planes of the scene reflect them. Between symmetry planes that face each
/// other it holds one image of the scene beside the scene. A solved scene has an extension; none is drawn where memory would not allow it.
pub(crate) fn even_extension(scene: &Scene) -> Option<EvenExtension> {
    EvenExtension::of(scene).ok().flatten()
}

fn focus_distance(transport: &Transport, camera: &Camera) -> Option<f64> {
    let dir = (camera.target - camera.origin).normalized();
    let wall = transport.closest_hit(camera.origin, dir, 0.0, f64::INFINITY).map(|h| h.t);
    let end = wall.map_or_else(|| transport.exterior_point(camera.origin, dir), |t| camera.origin + dir * t);
    let mut pane = None;
    transport.pane_crossings(camera.origin, end, &mut |h| pane = pane.or(Some(h.t)));
    pane.or(wall)
}

/// Renders the view of a camera from an integrator.
pub(crate) fn render_pixels(
    integrator: &Integrator,
    camera: &PerspectiveCamera,
    options: &RenderOptions,
    progress: &dyn Progress,
) -> Image {
    let (width, height) = (options.width, options.height);
    progress.begin("render", height as u64);
    let adaptive = options.samples == 0;
    if adaptive && !camera.has_lens() && width * height > 0 {
        let pixels = AdaptiveSampler::new(integrator, camera, options).render(progress);
        progress.end();
        return Image { width, height, pixels };
    }
    // Behind a lens every ray has its own origin, so that neighbouring pixels cannot share medium segments.
    let samples = if adaptive { LENS_RAYS } else { options.samples };
    let options = &RenderOptions { samples, ..options.clone() };
    let pixel = |x: usize, y: usize| render_pixel(integrator, camera, options, [x, y]);
    let pixels = pixels_of_rows(0..height, width, progress, pixel);
    progress.end();
    Image { width, height, pixels }
}

/// Mean radiance of the rays of a pixel.
pub(crate) fn render_pixel(
    integrator: &Integrator,
    camera: &PerspectiveCamera,
    o: &RenderOptions,
    [x, y]: [usize; 2],
) -> [f32; 3] {
    let (n, count) = (o.samples.max(1), o.light_samples.max(1));
    let shift = pixel_shift(x, y);
    let mut sum = Bands::ZERO;
    for i in 0..n {
        let [dx, dy] = subpixel(i, n);
        let at = [(x as f64 + dx) / o.width as f64, (y as f64 + dy) / o.height as f64];
        let (origin, dir) = camera.ray(at, i, [shift[1], shift[2]]);
        let sampler = RaySampler::of_ray(i, count, shift);
        sum += integrator.radiance(ViewRay { origin, dir }, sampler);
    }
    to_pixel(sum / n as f64)
}
