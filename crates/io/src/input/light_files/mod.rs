//! Files of lights: luminaires (`photometry`: IES LM-63, EULUMDAT) and pictures of skies (`sky_picture`: OpenEXR; `radiance_hdr`: Radiance).

pub(crate) mod photometry;
pub(crate) mod radiance_hdr;
pub(crate) mod sky_picture;
