# SPDX-License-Identifier: GPL-3.0-or-later
# Plays what `scripts/rumple vat --image exr` or the button "Export Vertex Animation" has written, copied to res://garment.
#   godot3 --path . --picture=FILE.png [--frame=N]   writes one picture and ends
#   ... --normals [--x=X --y=Y]   colours are normals, seen from above X, Y: what the test measures
extends Spatial

const FOLDER = "res://garment"
const HALF_SIZE = 0.45  # of the picture, metres, where --normals asks for one that is measured

var material = ShaderMaterial.new()
var frames = 1
var rate = 24.0
var way = []  # of the whole by frame, where it was exported in place
var shown = MeshInstance.new()
var camera = Camera.new()
var stand = Vector3()  # of the camera at the first frame
var options = {}


func _ready():
    for word in OS.get_cmdline_args():
        var parts = word.trim_prefix("--").split("=")
        options[parts[0]] = parts[1] if parts.size() > 1 else "yes"
    var garment = _garment()
    if garment == null:
        printerr("There is no garment: copy what Rumple has exported to the folder garment, with EXR textures")
        get_tree().quit(1)
        return
    add_child(garment)
    _add_camera(_whole_box(garment.get_aabb()))
    if options.has("picture"):
        _write_picture()


# The first frame's box, and wherever the clip moves it; in place: where it is.
func _whole_box(box):
    var least = material.get_shader_param("least")
    var most = material.get_shader_param("most")
    if options.has("picture"):
        _show(float(options.get("frame", "0")))
        box.position += shown.translation
    var low = Vector3(least.x, least.z, -most.y)
    return box.merge(AABB(box.position + low, box.size + Vector3(most.x, most.z, -least.y) - low))


func _process(_delta):
    if not options.has("picture"):
        _show(fmod(OS.get_ticks_msec() * 0.001 * rate, float(frames)))
        camera.translation = stand + shown.translation


func _show(frame):
    material.set_shader_param("frame", frame)
    if way.size() > 0:
        var before = int(clamp(frame, 0, frames - 1))
        var from = _vector(way[before])
        var at = from.linear_interpolate(_vector(way[min(before + 1, frames - 1)]), clamp(frame - before, 0.0, 1.0))
        shown.translation = Vector3(at.x, at.z, -at.y)  # Blender's z is up


# The mesh with the shader, or null.
func _garment():
    var files = {}
    var folder = Directory.new()
    if folder.open(FOLDER) != OK:
        return null
    folder.list_dir_begin(true)
    var file = folder.get_next()
    while file != "":
        for ending in ["_vat.exr", "_vnrm.exr", "-remap_info.json", ".glb"]:
            if file.ends_with(ending):
                files[ending] = FOLDER + "/" + file
        file = folder.get_next()
    if files.size() < 4:
        return null
    var mesh = _first_mesh(load(files[".glb"]).instance())
    _set_up(files)
    shown.mesh = mesh
    shown.material_override = material
    shown.extra_cull_margin = 16384.0  # the shader moves it out of the box of the first frame
    return shown


func _first_mesh(node):
    if node is MeshInstance:
        return node.mesh
    for child in node.get_children():
        var found = _first_mesh(child)
        if found != null:
            return found
    return null


func _set_up(files):
    var file = File.new()
    file.open(files["-remap_info.json"], File.READ)
    var about = JSON.parse(file.get_as_text()).result
    var remap = about["os-remap"]
    frames = int(remap["Frames"])
    if about.has("rumple"):
        rate = about["rumple"]["frames_a_second"]
        way = about["rumple"].get("way", [])
    material.shader = load("res://vat.shader")
    material.set_shader_param("positions", _texture(files["_vat.exr"]))
    material.set_shader_param("normals", _texture(files["_vnrm.exr"]))
    material.set_shader_param("least", _vector(remap["Min"]))
    material.set_shader_param("most", _vector(remap["Max"]))
    material.set_shader_param("frames", frames)
    material.set_shader_param("show_normals", options.has("normals"))


func _vector(numbers):
    return Vector3(numbers[0], numbers[1], numbers[2])


# As it is: no filter, no mipmaps. A game that is exported imports it with these flags instead.
func _texture(path):
    var image = Image.new()
    image.load(path)
    var texture = ImageTexture.new()
    texture.create_from_image(image, 0)
    return texture


func _add_camera(box):
    var middle = box.position + box.size / 2.0
    add_child(camera)
    if options.has("normals"):  # from above: to the right Blender's x, upwards its y
        camera.set_orthogonal(2.0 * HALF_SIZE, 0.01, 20.0)
        camera.translation = Vector3(float(options.get("x", "0")), 5.0, -float(options.get("y", "0")))
        camera.rotation_degrees = Vector3(-90.0, 0.0, 0.0)
    else:
        camera.translation = middle + Vector3(0.5, 0.45, 1.0).normalized() * box.get_longest_axis_size() * 1.3
        camera.look_at(middle, Vector3.UP)
        var light = DirectionalLight.new()
        light.rotation_degrees = Vector3(-40.0, 60.0, 0.0)
        light.light_energy = 0.8
        add_child(light)
    var world = Environment.new()
    world.background_mode = Environment.BG_COLOR
    world.background_color = Color.black if options.has("normals") else Color(0.2, 0.21, 0.23)
    world.ambient_light_color = Color.white
    world.ambient_light_energy = 0.0 if options.has("normals") else 0.15
    camera.environment = world
    camera.current = true
    stand = camera.translation


func _write_picture():
    _show(float(options.get("frame", "0")))
    for _wait in range(4):
        yield(get_tree(), "idle_frame")
    yield(VisualServer, "frame_post_draw")
    var picture = get_viewport().get_texture().get_data()
    picture.flip_y()
    get_tree().quit(0 if picture.save_png(options["picture"]) == OK else 1)
