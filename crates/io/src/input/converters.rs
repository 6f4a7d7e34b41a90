//! Formats that are not read, and for each a command that converts its files to one that is.

use std::path::Path;

/// Formats that are converted by the same command.
struct Converter {
    extensions: &'static [&'static str],
    /// Name of the formats.
    name: &'static str,
    command: &'static str,
}

/// All formats. Commands are those of the programs' manuals: Assimp 5 (`assimp export`), Blender 4 (`bpy.ops`), Gmsh 4 (chapter "Gmsh command-line
/// interface"), IfcOpenShell (`IfcConvert`), meshio 5 (`meshio convert`), OpenVDB 10 (`nanovdb_convert`).
const CONVERTERS: [Converter; 13] = [
    Converter { extensions: &["ifc"], name: "IFC", command: "IfcConvert in.ifc out.glb" },
    Converter { extensions: &["step", "stp"], name: "STEP", command: "gmsh in.step -2 -o out.msh" },
    Converter { extensions: &["iges", "igs"], name: "IGES", command: "gmsh in.iges -2 -o out.msh" },
    Converter { extensions: &["brep"], name: "BREP", command: "gmsh in.brep -2 -o out.msh" },
    Converter {
        extensions: &["usd", "usda", "usdc", "usdz"],
        name: "USD",
        command: "blender -b --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); bpy.ops.wm.usd_import(filepath='in.usd'); bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter {
        extensions: &["fbx"],
        name: "FBX",
        command: "blender -b --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); bpy.ops.import_scene.fbx(filepath='in.fbx'); bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter {
        extensions: &["blend"],
        name: "Blender",
        command: "blender -b in.blend --python-expr \"import bpy; bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter { extensions: &["dae"], name: "COLLADA", command: "assimp export in.dae out.glb" },
    Converter { extensions: &["3ds"], name: "3DS", command: "assimp export in.3ds out.glb" },
    Converter { extensions: &["3mf"], name: "3MF", command: "assimp export in.3mf out.glb" },
    Converter { extensions: &["off"], name: "OFF", command: "meshio convert in.off out.ply" },
    Converter {
        extensions: &["vtk", "inp", "med", "bdf", "nas", "xdmf"],
        name: "such mesh",
        command: "meshio convert --output-format gmsh22 in.vtk out.msh",
    },
    Converter { extensions: &["nvdb"], name: "NanoVDB", command: "nanovdb_convert in.nvdb out.vdb" },
];

/// What is wrong with a file of a known format that is not read, and the command that converts it; none for other extensions.
pub(super) fn conversion_hint(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    let converter = CONVERTERS.iter().find(|c| c.extensions.contains(&extension.as_str()))?;
    // The command is that of the first extension.
    let [first, ..] = converter.extensions else { return None };
    let command = converter.command.replacen(&format!("in.{first}"), &format!("in.{extension}"), 1);
    let name = converter.name;
    Some(format!("{name} files are not read; convert this one: {command}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_has_a_command_for_its_files() {
        for converter in CONVERTERS {
            for extension in converter.extensions {
                let hint = conversion_hint(Path::new(&format!("a.{}", extension.to_uppercase()))).unwrap();
                assert!(hint.contains(&format!("in.{extension}")) && hint.contains("out."), "{hint}");
            }
        }
        assert_eq!(conversion_hint(Path::new("a.obj")), None);
        assert_eq!(conversion_hint(Path::new("obj")), None);
    }
}
