# A bur drills a ball of enamel. The surface is updated in place, brick by brick, and the force is printed.
extends Spatial

const BALL = '{"tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300}'

var tooth
var bricks = {}
var ticks = 0
var material = SpatialMaterial.new()

func _ready():
	var plugin = load("res://typodont.gdns")
	if not plugin.can_instance():
		# Otherwise each frame would end in a script error, and the program would never end.
		set_process(false)
		printerr("libtypodont_godot.so, or libtypodont.so that it needs, was not loaded")
		get_tree().quit(1)
		return
	tooth = plugin.new()
	material.albedo_color = Color(0.93, 0.9, 0.8)
	material.roughness = 0.6
	$Camera.look_at_from_position(Vector3(1.5, -3, 6.5), Vector3(0, 0, 1), Vector3(0, 1, 0))
	$Light.look_at_from_position(Vector3(-8, 5, 7), Vector3(0, 0, 2), Vector3(0, 0, 1))
	var why = tooth.open(BALL)
	if why != "":
		printerr(why)
		get_tree().quit(1)
		return
	show_changes()
	print("%d bricks" % bricks.size())

func show_changes():
	var parts = tooth.mesh()
	for i in range(0, parts.size(), 4):
		var key = parts[i]
		if not bricks.has(key):
			bricks[key] = MeshInstance.new()
			bricks[key].mesh = ArrayMesh.new()
			bricks[key].material_override = material
			add_child(bricks[key])
		var mesh = bricks[key].mesh
		while mesh.get_surface_count() > 0:
			mesh.surface_remove(0)
		if parts[i + 3].size() > 0:
			var arrays = []
			arrays.resize(Mesh.ARRAY_MAX)
			arrays[Mesh.ARRAY_VERTEX] = parts[i + 1]
			arrays[Mesh.ARRAY_NORMAL] = parts[i + 2]
			arrays[Mesh.ARRAY_INDEX] = parts[i + 3]
			mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
	return parts.size() / 4

func _process(_delta):
	# 16 ticks per frame, so that 125 frames show 2 s of simulated time.
	var force = Vector3()
	for _i in range(16):
		ticks += 1
		var z = 3.7 - 0.0005 * min(ticks, 1000)
		force = tooth.tick(ticks * 0.001, Vector3(0, 0, z), Quat(), 1.0)
	var changed = show_changes()
	if ticks % 496 == 0:
		print("%.3f s: %.3f N, %.4f mm3, %d bricks changed" % [ticks * 0.001, force.z, tooth.removed(), changed])
	if ticks >= 2000:
		finish()

func finish():
	set_process(false)
	tooth.tick(0, Vector3(NAN, 0, 0), Quat(), 1.0)
	print("refused: " + tooth.error())
	var picture = OS.get_environment("TYPODONT_SCREENSHOT")
	if picture != "":
		yield(VisualServer, "frame_post_draw")
		var image = get_viewport().get_texture().get_data()
		image.flip_y()
		image.save_png(picture)
	print("undone: %s" % tooth.undo())
	get_tree().quit()
