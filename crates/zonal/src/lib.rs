//! The zonal method from a scene to a picture.
