//! Textures, images and samplers of a glTF document that name what is not there.
//!
//! A document with such an entry is not valid, but most are never used: exporters leave textures without images behind. [`repair`] replaces each broken
//! reference by one to an image whose name tells the defect, so that the document validates; a material that needs the image is refused with that defect, and
//! otherwise the defect is a note. Samplers are not read.

use serde_json::{Map, Value, json};

/// Beginning of the name of an image that stands for a broken one; the defect follows.
pub(super) const BROKEN_IMAGE: &str = "\u{1}broken: ";

/// Values that the keys of samplers may have.
const SAMPLER_VALUES: [(&str, &[u64]); 4] = [
    ("magFilter", &[9728, 9729]),
    ("minFilter", &[9728, 9729, 9984, 9985, 9986, 9987]),
    ("wrapS", &[33071, 33648, 10497]),
    ("wrapT", &[33071, 33648, 10497]),
];
/// Extensions of textures whose images are not read, and the commands of glTF Transform 4 that convert them.
const TEXTURE_EXTENSIONS: [(&str, &str); 3] = [
    ("KHR_texture_basisu", "npx @gltf-transform/cli ktxdecompress in.glb out.glb"),
    ("EXT_texture_webp", "npx @gltf-transform/cli png in.glb out.glb --formats \"*\""),
    ("EXT_texture_avif", "npx @gltf-transform/cli png in.glb out.glb --formats \"*\""),
];
/// Depth of the tables of materials that are searched for textures.
const MAX_DEPTH: usize = 16;

/// Replaces the broken references of a document, and returns the defects.
pub(super) fn repair(root: &mut Value) -> Vec<String> {
    let Some(root) = root.as_object_mut() else { return Vec::new() };
    let mut defects = Vec::new();
    let view_count = length(root, "bufferViews");
    let mut images = take_list(root, "images");
    let mut textures = take_list(root, "textures");
    let mut samplers = take_list(root, "samplers");
    samplers.iter_mut().enumerate().for_each(|(i, s)| repair_sampler(i, s, &mut defects));
    images.iter_mut().enumerate().for_each(|(i, image)| repair_image(i, image, view_count, &mut defects));
    for (i, texture) in textures.iter_mut().enumerate() {
        repair_texture(i, texture, samplers.len(), &mut images, &mut defects);
    }
    let own_count = textures.len();
    let mut missing = MissingTextures { own_count, images, textures, defects };
    if let Some(materials) = root.get_mut("materials") {
        missing.repair_infos(materials, 0);
    }
    let MissingTextures { images, textures, defects, .. } = missing;
    for (key, list) in [("images", images), ("textures", textures), ("samplers", samplers)] {
        if !list.is_empty() {
            root.insert(key.into(), Value::Array(list));
        }
    }
    defects
}

fn length(root: &Map<String, Value>, key: &str) -> usize {
    root.get(key).and_then(Value::as_array).map_or(0, Vec::len)
}

fn take_list(root: &mut Map<String, Value>, key: &str) -> Vec<Value> {
    match root.remove(key) {
        Some(Value::Array(list)) => list,
        _ => Vec::new(),
    }
}

fn is_index(value: Option<&Value>, count: usize) -> bool {
    value.and_then(Value::as_u64).is_some_and(|i| i < count as u64)
}

/// An image that stands for a broken one.
fn broken_image(defect: &str) -> Value {
    json!({ "name": format!("{BROKEN_IMAGE}{defect}") })
}

fn repair_sampler(index: usize, sampler: &mut Value, defects: &mut Vec<String>) {
    let is_valid = |own: &Map<String, Value>| {
        SAMPLER_VALUES.iter().all(|(key, values)| {
            own.get(*key).is_none_or(|v| v.as_u64().is_some_and(|v| values.contains(&v)))
        })
    };
    if !sampler.as_object().is_some_and(is_valid) {
        defects.push(format!("sampler {index} has values that are not of glTF"));
        *sampler = json!({});
    }
}

fn repair_image(index: usize, image: &mut Value, view_count: usize, defects: &mut Vec<String>) {
    let defect = match image.as_object() {
        None => "is no table",
        Some(own) => match (own.get("bufferView"), own.get("uri")) {
            (None, None) => "has neither data nor a file",
            (Some(view), _) if !is_index(Some(view), view_count) => "names a buffer view that is not there",
            (None, Some(uri)) if !uri.is_string() => "names no file",
            _ => return,
        },
    };
    let defect = format!("image {index} {defect}");
    *image = broken_image(&defect);
    defects.push(defect);
}

fn repair_texture(
    index: usize,
    texture: &mut Value,
    sampler_count: usize,
    images: &mut Vec<Value>,
    defects: &mut Vec<String>,
) {
    if !texture.is_object() {
        *texture = json!({});
    }
    let Some(own) = texture.as_object_mut() else { return };
    if own.contains_key("sampler") && !is_index(own.get("sampler"), sampler_count) {
        own.remove("sampler");
        defects.push(format!("texture {index} names a sampler that is not there"));
    }
    if is_index(own.get("source"), images.len()) {
        return;
    }
    let extensions = own.get("extensions").and_then(Value::as_object);
    let known = TEXTURE_EXTENSIONS.iter().find(|(name, _)| extensions.is_some_and(|e| e.contains_key(*name)));
    let defect = match (known, own.get("source").and_then(Value::as_u64)) {
        (Some((name, command)), None) => {
            format!("texture {index} has an image of {name} alone, which is not read ({command} converts it)")
        }
        (_, Some(source)) => format!("texture {index} names image {source}, which is not there"),
        (None, None) => format!("texture {index} names no image"),
    };
    own.insert("source".into(), json!(images.len()));
    images.push(broken_image(&defect));
    defects.push(defect);
}

/// The lists of a document while references to textures that are not there are replaced.
struct MissingTextures {
    /// Number of textures of the file.
    own_count: usize,
    images: Vec<Value>,
    textures: Vec<Value>,
    defects: Vec<String>,
}

impl MissingTextures {
    /// Gives the keys `…Texture` of a table, and of the tables in it, an index that is there.
    fn repair_infos(&mut self, value: &mut Value, depth: usize) {
        if depth > MAX_DEPTH {
            return;
        }
        match value {
            Value::Array(list) => list.iter_mut().for_each(|v| self.repair_infos(v, depth + 1)),
            Value::Object(own) => {
                for (key, v) in own.iter_mut() {
                    if let Some(info) = v.as_object_mut().filter(|_| key.ends_with("Texture")) {
                        self.repair_info(key, info);
                    }
                    self.repair_infos(v, depth + 1);
                }
            }
            _ => {}
        }
    }

    fn repair_info(&mut self, key: &str, info: &mut Map<String, Value>) {
        if is_index(info.get("index"), self.own_count) {
            return;
        }
        let defect = match info.get("index").and_then(Value::as_u64) {
            Some(i) => format!("{key} names texture {i}, which is not there"),
            None => format!("{key} names no texture"),
        };
        info.insert("index".into(), json!(self.textures.len()));
        self.textures.push(json!({ "source": self.images.len() }));
        self.images.push(broken_image(&defect));
        self.defects.push(defect);
    }
}
