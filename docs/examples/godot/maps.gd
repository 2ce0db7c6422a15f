# SPDX-License-Identifier: GPL-3.0-or-later
# Plays Wrinkle Maps: what "Export Wrinkle Maps" has written with maps and Influences by Frame, and the rigged mesh
# as .glb, copied to res://face.
#   godot3 --path . maps.tscn --picture=FILE.png [--frame=N]   writes one picture and ends
#   ... --normals [--x=X --y=Y]   colours are normals, seen from the front of X, Y: what the test measures
extends Spatial

const FOLDER = "res://face/"
const WIDTH = 4096      # of maps.shader
const MOST_POSES = 8    # likewise
const HALF_SIZE = 0.07  # of the picture, metres, where --normals asks for one that is measured

var material = ShaderMaterial.new()
var rig = {}
var clip = {}
var player = null
var options = {}


func _ready():
    for word in OS.get_cmdline_args():
        var parts = word.trim_prefix("--").split("=")
        options[parts[0]] = parts[1] if parts.size() > 1 else "yes"
    var why = _load_face()
    if why != "":
        printerr(why)
        get_tree().quit(1)
        return
    if options.has("picture"):
        _write_picture()


func _process(_delta):
    if not options.has("picture") and clip.has("influence"):
        _show(clip["first"] + fmod(OS.get_ticks_msec() * 0.001 * clip["fps"], float(clip["influence"].size())))


# A frame of Blender's scene.
func _show(frame):
    material.set_shader_param("frame", frame - clip["first"])
    if player != null:
        player.seek(frame / clip["fps"], true)


# Empty, or what is missing.
func _load_face():
    var files = _files()
    if not (files.has(".glb") and files.has(".frames.json") and files.has(".json")):
        return "There is no face: copy what Rumple has exported, with Influences by Frame, and a .glb to the folder face"
    rig = _json(files[".json"])
    clip = _json(files[".frames.json"])
    if rig["poses"].size() > MOST_POSES:
        return "This sample shows %d poses, the face has %d" % [MOST_POSES, rig["poses"].size()]
    var scene = load(files[".glb"]).instance()
    add_child(scene)
    var mesh = _find(scene, "MeshInstance")
    player = _find(scene, "AnimationPlayer")
    if mesh == null or mesh.skin == null:
        return "The mesh of the .glb has no skin: export it with its armature"
    if player != null:
        player.play(player.get_animation_list()[0])
        player.stop(false)
    _set_up(mesh)
    _add_camera(mesh.get_aabb())
    return ""


func _files():
    var found = {}
    var folder = Directory.new()
    if folder.open(FOLDER) != OK:
        return found
    folder.list_dir_begin(true)
    var file = folder.get_next()
    while file != "":
        for ending in [".frames.json", ".json", ".glb"]:
            if file.ends_with(ending):
                found[ending] = FOLDER + file
                break
        file = folder.get_next()
    return found


func _json(path):
    var file = File.new()
    file.open(path, File.READ)
    return JSON.parse(file.get_as_text()).result


func _find(node, kind):
    if node.is_class(kind):
        return node
    for child in node.get_children():
        var found = _find(child, kind)
        if found != null:
            return found
    return null


func _set_up(mesh):
    material.shader = load("res://maps.shader")
    material.set_shader_param("weights", _table(_weights(mesh)))
    material.set_shader_param("influences", _table(_influences()))
    material.set_shader_param("maps", _maps())
    material.set_shader_param("neutral_map", _neutral())
    material.set_shader_param("bones", rig["bones"].size())
    material.set_shader_param("poses", rig["poses"].size())
    material.set_shader_param("frames", clip["influence"].size())
    material.set_shader_param("whole", rig["maps"] == "whole")
    material.set_shader_param("show_normals", options.has("normals"))
    mesh.mesh = _numbered(mesh.mesh)
    mesh.material_override = material


# The same mesh with the number of each vertex as UV2, not compressed: half floats count to 2048.
func _numbered(mesh):
    var arrays = mesh.surface_get_arrays(0)
    var numbers = PoolVector2Array()
    for vertex in range(arrays[ArrayMesh.ARRAY_VERTEX].size()):
        numbers.append(Vector2(vertex, 0))
    arrays[ArrayMesh.ARRAY_TEX_UV2] = numbers
    var made = ArrayMesh.new()
    made.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, [], 0)
    return made


# Of each vertex for each bone of the JSON. Bones that are not in it have no influence.
func _weights(mesh):
    var skeleton = mesh.get_node(mesh.skeleton)
    var of_bind = []
    for bind in range(mesh.skin.get_bind_count()):
        var bone = mesh.skin.get_bind_bone(bind)
        of_bind.append(_bone_number(skeleton.get_bone_name(bone) if bone >= 0 else mesh.skin.get_bind_name(bind)))
    var arrays = mesh.mesh.surface_get_arrays(0)
    var binds = arrays[ArrayMesh.ARRAY_BONES]
    var shares = arrays[ArrayMesh.ARRAY_WEIGHTS]
    var count = rig["bones"].size()
    var out = PoolRealArray()
    for vertex in range(arrays[ArrayMesh.ARRAY_VERTEX].size()):
        var row = []
        for _bone in range(count):
            row.append(0.0)
        for corner in range(4 * vertex, 4 * vertex + 4):
            var bone = of_bind[int(binds[corner])]
            if bone >= 0:
                row[bone] += shares[corner]
        out.append_array(PoolRealArray(row))
    return out


# -1 where the JSON has no such bone. Godot's importer makes "brow.L" to "brow_l".
func _bone_number(name):
    for number in range(rig["bones"].size()):
        if _plain(name) == _plain(rig["bones"][number]["name"]):
            return number
    return -1


func _plain(name):
    return name.to_lower().replace(".", "_").replace(" ", "_")


# Of each frame for each bone and pose, times the strength of the pose; a pose without a map does not count.
func _influences():
    var out = PoolRealArray()
    for frame in clip["influence"]:
        for bone in frame:
            for pose in range(bone.size()):
                var about = rig["poses"][pose]
                out.append(bone[pose] * about["strength"] * rig["gain"] if about["map"] != "" else 0.0)
    return out


# Floats as a texture, WIDTH in a row.
func _table(values):
    var rows = (values.size() + WIDTH - 1) / WIDTH
    var stream = StreamPeerBuffer.new()
    stream.resize(4 * WIDTH * int(max(rows, 1)))
    for value in values:
        stream.put_float(value)
    var image = Image.new()
    image.create_from_data(WIDTH, int(max(rows, 1)), false, Image.FORMAT_RF, stream.data_array)
    return _texture(image, 0)


func _texture(image, flags):
    var texture = ImageTexture.new()
    texture.create_from_image(image, flags)
    return texture


# As it is: no mipmaps, not sRGB. A game that is exported imports it instead.
func _image(file):
    var image = Image.new()
    image.load(FOLDER + file)
    image.convert(Image.FORMAT_RGB8)
    return image


# All of one size. A pose without a map is flat.
func _maps():
    var images = []
    var size = Vector2(1, 1)
    for pose in rig["poses"]:
        images.append(_image(pose["map"]) if pose["map"] != "" else null)
        if images[-1] != null:
            size = images[-1].get_size()
    var layers = TextureArray.new()
    layers.create(int(size.x), int(size.y), images.size(), Image.FORMAT_RGB8, Texture.FLAG_FILTER | Texture.FLAG_REPEAT)
    for number in range(images.size()):
        layers.set_layer_data(images[number] if images[number] != null else _flat(size), number)
    return layers


func _neutral():
    var image = _image(rig["neutral_map"]) if rig["neutral_map"] != "" else _flat(Vector2(1, 1))
    return _texture(image, Texture.FLAG_FILTER | Texture.FLAG_REPEAT)


func _flat(size):
    var image = Image.new()
    image.create(int(size.x), int(size.y), false, Image.FORMAT_RGB8)
    image.fill(Color(0.5, 0.5, 1.0))
    return image


func _add_camera(box):
    var camera = Camera.new()
    var middle = box.position + box.size / 2.0
    add_child(camera)
    if options.has("normals"):  # from the front: to the right Blender's x, upwards its z
        camera.set_orthogonal(2.0 * HALF_SIZE, 0.01, 20.0)
        camera.translation = Vector3(float(options.get("x", "0")), float(options.get("y", "0")), 2.0)
    else:
        camera.translation = middle + Vector3(0.1, 0.1, 1.3) * box.get_longest_axis_size()
        camera.look_at(middle, Vector3.UP)
        var light = DirectionalLight.new()
        light.rotation_degrees = Vector3(-35.0, 50.0, 0.0)
        add_child(light)
    var world = Environment.new()
    world.background_mode = Environment.BG_COLOR
    world.background_color = Color.black if options.has("normals") else Color(0.2, 0.21, 0.23)
    world.ambient_light_color = Color.white
    world.ambient_light_energy = 0.0 if options.has("normals") else 0.15
    camera.environment = world
    camera.current = true


func _write_picture():
    _show(float(options.get("frame", str(clip["first"]))))
    for _wait in range(4):
        yield(get_tree(), "idle_frame")
    yield(VisualServer, "frame_post_draw")
    var picture = get_viewport().get_texture().get_data()
    picture.flip_y()
    get_tree().quit(0 if picture.save_png(options["picture"]) == OK else 1)
