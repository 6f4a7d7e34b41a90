//! stub
use crate::{Demand, Factor};
use zonal_scene::Plate;
pub(super) fn plate_plate(_a: &Plate, _b: &Plate, _kappa: f64, _demand: Demand) -> Factor {
    unimplemented!()
}
