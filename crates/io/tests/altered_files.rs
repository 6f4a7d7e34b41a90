//! Truncated and altered files never panic.

use crate::support;

use support::vdb::Vdb;
use support::{CUBE, Folder, NpyOrder, Quad, f32s, npy, png};
use zonal_io::input::parse_scene;

/// Marsaglia's xorshift: the same bytes on every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Calls `read` with every 64th truncation of a file and 400 altered copies (`ZONAL_FUZZ` of them where set); gives how many of 2,000 would be accepted.
fn alter(file: &[u8], mut read: impl FnMut(&[u8]) -> bool) -> usize {
    let mut accepted = 0;
    for k in 0..=64 {
        accepted += usize::from(read(&file[..file.len() * k / 64]));
    }
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let rounds = std::env::var("ZONAL_FUZZ").ok().and_then(|n| n.parse().ok()).unwrap_or(400);
    for _ in 0..rounds {
        let mut bytes = file.to_vec();
        for _ in 0..1 + random.below(4) {
            let at = random.below(bytes.len());
            bytes[at] = match random.below(3) {
                0 => random.next() as u8,
                1 => bytes[at] ^ (1 << random.below(8)),
                _ => [0, 0xff, b'-', b'9', b'e', b'"', b'{'][random.below(7)],
            };
        }
        accepted += usize::from(read(&bytes));
    }
    accepted * 2000 / rounds
}

fn through_file(name: &str, file: &[u8], text: &str) -> usize {
    let folder = Folder::new();
    alter(file, |bytes| {
        folder.put(name, bytes);
        match parse_scene(text, Some(folder.path()), "fuzz.toml") {
            Ok(_) => true,
            Err(e) => {
                assert!(e.to_string().starts_with("fuzz.toml:"), "{e}");
                false
            }
        }
    })
}

// Guards (files): no file makes the program panic.
#[test]
fn altered_glb_files_do_not_panic() {
    let picture = png(4, 4, &[200; 48]);
    let mut q = Quad::default();
    let start = q.binary.len();
    q.binary.extend(&picture);
    q.views += &format!(r#",{{"buffer":0,"byteOffset":{start},"byteLength":{}}}"#, picture.len());
    q.more = r#","images":[{"bufferView":3}],"textures":[{"source":0}]"#.into();
    q.material = r#"{"name":"w","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}"#.into();
    q.nodes = r#"{"children":[1],"rotation":[0,0,0.6,0.8]},{"mesh":0,"scale":[-1,1,1]}"#.into();
    let n = through_file("a.glb", &q.glb(), "[[surface]]\nmesh={file='a.glb'}");
    assert!(n > 50, "{n}");
}

#[test]
fn altered_obj_and_mtl_files_do_not_panic() {
    let obj = format!("mtllib a.mtl\nusemtl a\nvt 0 0\n{CUBE}f -1/1/1 -2/-1 -3//2 -4 -6\nf 1 2 3\n");
    let n = through_file("a.obj", obj.as_bytes(), "[[surface]]\nmesh={file='a.obj'}");
    assert!(n > 100, "{n}");
    let folder = Folder::new().with("a.obj", obj);
    let mtl = b"newmtl a\nKd 0.5 0.5 0.5\nKe 1 1 1\nmap_Kd -s 1 1 1 a.png\nd 0.5\n";
    let n = alter(mtl, |bytes| {
        folder.put("a.mtl", bytes);
        parse_scene("[[surface]]\nmesh={file='a.obj'}", Some(folder.path()), "fuzz.toml").is_ok()
    });
    assert!(n > 100, "{n}");
}

#[test]
fn altered_npy_files_do_not_panic() {
    let file = npy("<f4", NpyOrder::Fortran, "(2, 2, 3)", &f32s(&[0.5; 12]));
    let text = "[medium]\nmin=[0,0,0]\nmax=[1,1,1]\ncells=[3,3,3]\n[[medium.region]]\n\
                density={file='a.npy',min=[0,0,0],max=[1,1,1]}";
    let n = through_file("a.npy", &file, text);
    assert!(n > 100, "{n}");
}

#[test]
fn altered_images_do_not_panic() {
    let noise: Vec<u8> = (0..16 * 16 * 3).map(|i| (i * i % 251) as u8).collect();
    let text = "[[surface]]\nrectangle={origin=[0,0,0],edge1=[1,0,0],edge2=[0,1,0]}\ntexture='a.png'";
    let n = through_file("a.png", &png(16, 16, &noise), text);
    assert!(n > 0, "{n}");
}

#[test]
fn altered_scenes_do_not_panic() {
    let text = "name='a'\n[[surface]]\nname='f'\nrectangle={origin=[0,0,0],edge1=[4,0,0],edge2=[0,6,0]}\nreflectance=[0.1,0.2,0.3]\n\
                [[surface]]\nroom={min=[0,0,0],max=[4,6,3]}\nfaces.x0={emission=1}\nomit=['z1']\n\
                [[pane]]\npolygon=[[1,0,1],[2,0,1],[2,0,2],[1,0,2]]\nthickness=0.01\nextinction=[10,200,200]\n\
                [medium]\nmin=[0,0,0]\nmax=[4,6,3]\ncells=[4,6,3]\nextinction=0.1\n[[medium.region]]\n\
                box={min=[0,0,0],max=[1,1,1]}\nalbedo=0.5\n[[light]]\nkind='sun'\ndirection=[0,0,-1]\nirradiance=10\n\
                [[camera]]\norigin=[1,1,1]\ntarget=[2,2,2]\n";
    let n = alter(text.as_bytes(), |bytes| {
        parse_scene(&String::from_utf8_lossy(bytes), None, "fuzz.toml").is_ok()
    });
    assert!(n > 20, "{n}");
}

// Guards (files): no file makes the program panic.
#[test]
fn altered_vdb_files_do_not_panic() {
    let text = "[medium]\nmin=[0,0,0]\nmax=[8,4,4]\ncells=[8,4,4]\nextinction=0.5\n[[medium.region]]\n\
                density={file='a.vdb'}\n";
    let half = "Tree_float_5_4_3_HalfFloat";
    // Most of the file are masks, where few changes are sound …
    let n = through_file("a.vdb", &Vdb { flags: 3, ..Vdb::default() }.bytes(), text);
    assert!(n > 10, "{n}");
    // … so its head and its end are altered more often.
    let file = Vdb { flags: 6, kind: half, ..Vdb::default() }.bytes();
    let folder = Folder::new();
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for _ in 0..700 {
        let mut bytes = file.clone();
        let (head, end) = (random.below(500), file.len() - 1 - random.below(800));
        bytes[head] = random.next() as u8;
        bytes[end] ^= 1 << random.below(8);
        folder.put("a.vdb", &bytes);
        if let Err(e) = parse_scene(text, Some(folder.path()), "fuzz.toml") {
            assert!(e.to_string().starts_with("fuzz.toml:"), "{e}");
        }
    }
}

#[test]
fn altered_vol_files_do_not_panic() {
    let mut file = b"VOL\x03".to_vec();
    [1u32, 2, 3, 2, 1].iter().for_each(|n| file.extend(n.to_le_bytes()));
    file.extend(f32s(&[0.0, 0.0, 0.0, 2.0, 3.0, 2.0]));
    file.extend(f32s(&[1.5; 12]));
    let text =
        "[medium]\nmin=[0,0,0]\nmax=[2,3,2]\ncells=[2,2,2]\n[[medium.region]]\ndensity={file='a.vol'}\n";
    let n = through_file("a.vol", &file, text);
    assert!(n > 50, "{n}");
}
