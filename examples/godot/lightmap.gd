# A solution of zonal as a lightmap: zonal export room.npz -o room.glb --lightmap, into this folder.
extends Node3D

@export_file("*.glb") var file := "res://room.glb"


func _ready() -> void:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	document.append_from_file(ProjectSettings.globalize_path(file), state)
	var model := document.generate_scene(state)
	add_child(model)
	var about: Dictionary = state.json["scenes"][0]["extras"]
	var folder := ProjectSettings.globalize_path(file.get_base_dir())
	var picture := Image.load_from_file(folder.path_join(about["lightmap"]["file"]))
	var lightmap := ImageTexture.create_from_image(picture)
	for node in model.find_children("*", "MeshInstance3D", true, false):
		for i in node.mesh.get_surface_count():
			if node.mesh.surface_get_format(i) & Mesh.ARRAY_FORMAT_TEX_UV2:
				node.set_surface_override_material(i, lit(node.mesh.surface_get_material(i), lightmap, about["exposure"]))
	for camera in model.find_children("*", "Camera3D", true, false):
		camera.make_current()


# The material with the lightmap: exposure * (emissive + base colour * irradiance / pi).
func lit(from: StandardMaterial3D, lightmap: Texture2D, exposure: float) -> ShaderMaterial:
	var material := ShaderMaterial.new()
	material.shader = preload("res://lightmap.gdshader")
	material.set_shader_parameter("lightmap", lightmap)
	material.set_shader_parameter("exposure", exposure)
	material.set_shader_parameter("base_colour", from.albedo_color)
	material.set_shader_parameter("base_picture", from.albedo_texture)
	material.set_shader_parameter("emissive", from.emission)
	material.set_shader_parameter("emissive_energy", from.emission_energy_multiplier if from.emission_enabled else 0.0)
	material.set_shader_parameter("emissive_picture", from.emission_texture)
	return material
