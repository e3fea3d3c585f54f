## Shows exported heads, one after another, and gives their pixels to the page.
extends Node

const WITH_TANGENTS := 8
## The weights are a frame behind the shapes, and the head a frame behind the weights.
const FRAMES := 3

var _page := JavaScriptBridge.get_interface("facezip")


func _ready() -> void:
	for case: Dictionary in JSON.parse_string(FileAccess.get_file_as_string("res://cases.json")):
		await _show(case)
	_page.done(Engine.get_version_info()["string"])


## One head: a viewport of a few pixels a texel, and a camera in front that sees all of its tiles.
func _show(case: Dictionary) -> void:
	var size := Vector2i(case["size"][1], case["size"][0])
	var width := float(size.x) / size.y
	var viewport := SubViewport.new()
	viewport.own_world_3d = true
	viewport.size = size * int(case["zoom"])
	viewport.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var camera := Camera3D.new()
	camera.set_orthogonal(1.0, 0.1, 100.0)
	camera.position = Vector3(0.5 * width, 0.5, 50.0)
	camera.environment = _ambient()
	viewport.add_child(camera)
	var lights := Node3D.new()
	viewport.add_child(lights)
	if case.has("portrait"):
		_portray(case["portrait"], viewport, camera, lights)
	else:
		lights.add_child(DirectionalLight3D.new())
	var head := _head(case)
	viewport.add_child(head)
	var plain := _plain(width)
	viewport.add_child(plain)
	add_child(viewport)
	var face := _face_of(head)
	_page.mesh(case["name"], JSON.stringify(_described(face)))
	for view: String in case["views"]:
		var words: Dictionary = case["views"][view]
		lights.visible = words["lit"]
		camera.environment.ambient_light_energy = 0.0 if words["lit"] else 1.0
		head.visible = not words["plain"]
		plain.visible = words["plain"]
		_rewrite(face, words)
		for pose: String in case["poses"]:
			_pose(face, case["poses"][pose])
			if words["plain"]:
				plain.material_override.albedo_texture = _floats(case["name"], pose, size)
			for frame in FRAMES:
				await RenderingServer.frame_post_draw
			var image := viewport.get_texture().get_image()
			image.convert(Image.FORMAT_RGB8)
			_page.picture(case["name"], view, pose, Marshalls.raw_to_base64(image.get_data()))
	viewport.queue_free()


## A camera and suns as the case says, in the place of those for texels laid flat.
func _portray(portrait: Dictionary, viewport: SubViewport, camera: Camera3D, lights: Node3D) -> void:
	viewport.msaa_3d = Viewport.MSAA_4X
	var distance: float = portrait["distance"]
	camera.set_perspective(portrait["camera"]["field_of_view"], 0.1 * distance, 10.0 * distance)
	camera.transform = _looking(portrait["camera"]["origin"], portrait["camera"]["target"])
	camera.environment.background_color = Color(portrait["backdrop"])
	for sun: Dictionary in portrait["lights"]:
		var light := DirectionalLight3D.new()
		light.transform = _looking(sun["from"], [0, 0, 0])
		light.light_energy = sun["energy"]
		light.light_color = Color(sun["colour"][0], sun["colour"][1], sun["colour"][2]).linear_to_srgb()
		lights.add_child(light)


func _looking(from: Array, to: Array) -> Transform3D:
	var origin := Vector3(from[0], from[1], from[2])
	return Transform3D(Basis.looking_at(Vector3(to[0], to[1], to[2]) - origin), origin)


## Light from everywhere, of one: what is seen is the albedo.
func _ambient() -> Environment:
	var environment := Environment.new()
	environment.background_mode = Environment.BG_COLOR
	environment.background_color = Color.BLACK
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_COLOR
	environment.ambient_light_color = Color.WHITE
	environment.reflected_light_source = Environment.REFLECTION_SOURCE_DISABLED
	environment.tonemap_mode = Environment.TONE_MAPPER_LINEAR
	return environment


## As GUIDE.md says: the scene of the GLB, and the script on its face.
func _head(case: Dictionary) -> Node3D:
	var state := GLTFState.new()
	var document := GLTFDocument.new()
	document.append_from_file(case["head"], state, WITH_TANGENTS)
	var head := document.generate_scene(state)
	var face := _face_of(head)
	face.set_script(load(case["folder"].path_join("facezip_head.gd")))
	face.folder = case["folder"]
	for kind: String in case["gains"]:
		for named: String in case["gains"][kind]:
			face.gains[kind][named] = case["gains"][kind][named]
	return head


func _face_of(head: Node) -> MeshInstance3D:
	return head.find_children("*", "MeshInstance3D", true, false)[0]


## An ordinary material that shows a texture, in the place of the head.
func _plain(width: float) -> MeshInstance3D:
	var sheet := MeshInstance3D.new()
	sheet.mesh = QuadMesh.new()
	sheet.mesh.size = Vector2(width, 1.0)
	sheet.position = Vector3(0.5 * width, 0.5, 0.0)
	sheet.material_override = StandardMaterial3D.new()
	sheet.material_override.texture_filter = BaseMaterial3D.TEXTURE_FILTER_NEAREST
	return sheet


func _floats(case: String, pose: String, size: Vector2i) -> ImageTexture:
	var texels := FileAccess.get_file_as_bytes("res://plain/%s/%s" % [case, pose])
	return ImageTexture.create_from_image(Image.create_from_data(size.x, size.y, false, Image.FORMAT_RGBF, texels))


func _described(face: MeshInstance3D) -> Dictionary:
	var mesh: ArrayMesh = face.mesh
	var names := range(mesh.get_blend_shape_count()).map(mesh.get_blend_shape_name)
	var surfaces: Array[Dictionary] = []
	for surface in mesh.get_surface_count():
		var shapes := mesh.surface_get_blend_shape_arrays(surface)
		surfaces.append({
			"vertices": _numbers(mesh.surface_get_arrays(surface)[Mesh.ARRAY_VERTEX]),
			"shapes": shapes.map(func(arrays: Array) -> Array: return _numbers(arrays[Mesh.ARRAY_VERTEX])),
		})
	return {"names": names, "surfaces": surfaces, "skinned": face.skin != null, "saved": _saved(face)}


## What would be saved of the face with its scene: how many nodes, which of its properties, and its gains.
func _saved(face: MeshInstance3D) -> Dictionary:
	var packed := PackedScene.new()
	packed.pack(face)
	var state := packed.get_state()
	var properties := range(state.get_node_property_count(0)).map(
		func(at: int) -> String: return state.get_node_property_name(0, at)
	)
	return {"nodes": state.get_node_count(), "properties": properties, "gains": face.get("gains")}


func _numbers(points: PackedVector3Array) -> Array:
	return Array(points).map(func(point: Vector3) -> Array: return [point.x, point.y, point.z])


func _pose(face: MeshInstance3D, weights: Dictionary) -> void:
	for shape in face.get_blend_shape_count():
		var named := str(face.mesh.get_blend_shape_name(shape))
		face.set_blend_shape_value(shape, weights.get(named, 0.0))


## The exported shader, with a few words more where a view shows another of its numbers than the colour.
func _rewrite(face: MeshInstance3D, words: Dictionary) -> void:
	for surface in face.mesh.get_surface_count():
		var material: ShaderMaterial = face.get_surface_override_material(surface)
		if material == null:
			# In the editor the renderer alone has it.
			continue
		if not material.has_meta("code"):
			material.set_meta("code", material.shader.code)
		var code: String = material.get_meta("code")
		for find: String in words["replace"]:
			code = code.replace(find, words["replace"][find])
		var shader := Shader.new()
		shader.code = code + words["behind"]
		material.shader = shader
