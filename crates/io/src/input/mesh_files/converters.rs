//! Formats that are not read, and for each a command that converts its files to one that is.

use std::path::Path;

/// The content wanted from a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileContents {
    Mesh,
    Voxels,
}

/// Formats that are converted by the same command.
struct Converter {
    extensions: &'static [&'static str],
    contents: FileContents,
    /// Name of the formats.
    name: &'static str,
    command: &'static str,
}

/// All formats. Commands are those of the programs' manuals: Assimp 5 (`assimp export`), Blender 4 (`bpy.ops`), Gmsh 4 (chapter "Gmsh command-line
/// interface"), IfcOpenShell (`IfcConvert`), meshio 5 (`meshio convert`), OpenVDB 10 (`nanovdb_convert`).
const CONVERTERS: [Converter; 16] = [
    Converter {
        extensions: &["ifc"],
        contents: FileContents::Mesh,
        name: "IFC",
        command: "IfcConvert in.ifc out.glb",
    },
    Converter {
        extensions: &["step", "stp"],
        contents: FileContents::Mesh,
        name: "STEP",
        command: "gmsh in.step -2 -o out.msh",
    },
    Converter {
        extensions: &["iges", "igs"],
        contents: FileContents::Mesh,
        name: "IGES",
        command: "gmsh in.iges -2 -o out.msh",
    },
    Converter {
        extensions: &["brep"],
        contents: FileContents::Mesh,
        name: "BREP",
        command: "gmsh in.brep -2 -o out.msh",
    },
    Converter {
        extensions: &["usd", "usda", "usdc", "usdz"],
        contents: FileContents::Mesh,
        name: "USD",
        command: "blender -b --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); bpy.ops.wm.usd_import(filepath='in.usd'); bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter {
        extensions: &["fbx"],
        contents: FileContents::Mesh,
        name: "FBX",
        command: "blender -b --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); bpy.ops.import_scene.fbx(filepath='in.fbx'); bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter {
        extensions: &["blend"],
        contents: FileContents::Mesh,
        name: "Blender",
        command: "blender -b in.blend --python-expr \"import bpy; bpy.ops.export_scene.gltf(filepath='out.glb')\"",
    },
    Converter {
        extensions: &["dae"],
        contents: FileContents::Mesh,
        name: "COLLADA",
        command: "assimp export in.dae out.glb",
    },
    Converter {
        extensions: &["3ds"],
        contents: FileContents::Mesh,
        name: "3DS",
        command: "assimp export in.3ds out.glb",
    },
    Converter {
        extensions: &["3mf"],
        contents: FileContents::Mesh,
        name: "3MF",
        command: "assimp export in.3mf out.glb",
    },
    Converter {
        extensions: &["x3d"],
        contents: FileContents::Mesh,
        name: "X3D",
        command: "assimp export in.x3d out.glb",
    },
    Converter {
        extensions: &["lwo"],
        contents: FileContents::Mesh,
        name: "LightWave",
        command: "assimp export in.lwo out.glb",
    },
    Converter {
        extensions: &["wrl", "vrml"],
        contents: FileContents::Mesh,
        name: "VRML",
        command: "assimp export in.wrl out.glb",
    },
    Converter {
        extensions: &["off"],
        contents: FileContents::Mesh,
        name: "OFF",
        command: "meshio convert in.off out.ply",
    },
    Converter {
        extensions: &["vtk", "inp", "med", "bdf", "nas", "xdmf"],
        contents: FileContents::Mesh,
        name: "such mesh",
        command: "meshio convert --output-format gmsh22 in.vtk out.msh",
    },
    Converter {
        extensions: &["nvdb"],
        contents: FileContents::Voxels,
        name: "NanoVDB",
        command: "nanovdb_convert in.nvdb out.vdb",
    },
];

/// What is wrong with a file of a known format that is not read, and the command that converts it; none for other extensions.
pub(crate) fn conversion_hint(path: &Path, wanted: FileContents) -> Option<String> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    let is_one = |c: &&Converter| c.contents == wanted && c.extensions.contains(&extension.as_str());
    let converter = CONVERTERS.iter().find(is_one)?;
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
                let hint = conversion_hint(
                    Path::new(&format!("a.{}", extension.to_uppercase())),
                    converter.contents,
                )
                .unwrap();
                assert!(hint.contains(&format!("in.{extension}")) && hint.contains("out."), "{hint}");
            }
        }
        assert_eq!(conversion_hint(Path::new("a.obj"), FileContents::Mesh), None);
        assert_eq!(conversion_hint(Path::new("fbx"), FileContents::Mesh), None);
        assert_eq!(conversion_hint(Path::new("a.fbx"), FileContents::Voxels), None);
    }
}
