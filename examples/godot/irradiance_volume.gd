# A ball in an irradiance volume of zonal: zonal export room.npz -o room.volume.json --irradiance-volume, into this folder.
extends Node3D

@export_file("*.json") var file := "res://room.volume.json"


func _ready() -> void:
	var about: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(file))
	var bytes := FileAccess.get_file_as_bytes(file.get_base_dir().path_join(about["file"]))
	var low := vector(about["min"])
	var high := vector(about["max"])
	var material := ShaderMaterial.new()
	material.shader = preload("res://irradiance_volume.gdshader")
	for band in 3:
		material.set_shader_parameter(["red", "green", "blue"][band], texture(about["dims"], bytes, band))
	material.set_shader_parameter("low", low)
	material.set_shader_parameter("high", high)
	material.set_shader_parameter("factor", about["scale"] * about["exposure"])
	material.set_shader_parameter("colour", Vector3(0.5, 0.5, 0.5))
	var ball := MeshInstance3D.new()
	ball.mesh = SphereMesh.new()
	ball.material_override = material
	ball.scale = Vector3.ONE * 0.1 * (high - low).length()
	ball.position = (low + high) / 2.0
	add_child(ball)
	var camera := Camera3D.new()
	add_child(camera)
	# In the axes of the solution, where z may be up.
	camera.look_at_from_position(ball.position - Vector3(0, 0.2 * (high - low).length(), 0.01), ball.position, vector(about["up"]))
	camera.make_current()


func vector(list: Array) -> Vector3:
	return Vector3(list[0], list[1], list[2])


# The texture of one band: four coefficients a point.
func texture(dims: Array, bytes: PackedByteArray, band: int) -> ImageTexture3D:
	var slices: Array[Image] = []
	var size := int(dims[0]) * int(dims[1]) * 8
	for z in int(dims[2]):
		var first := (band * int(dims[2]) + z) * size
		slices.append(Image.create_from_data(dims[0], dims[1], false, Image.FORMAT_RGBAH, bytes.slice(first, first + size)))
	var out := ImageTexture3D.new()
	out.create(Image.FORMAT_RGBAH, dims[0], dims[1], dims[2], false, slices)
	return out
