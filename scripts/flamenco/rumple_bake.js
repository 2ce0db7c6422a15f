// SPDX-License-Identifier: GPL-3.0-or-later
// A job type for Flamenco 3: bakes the wrinkles of a file, one task a garment, each after those that it rests on.
// Copy it into the folder "scripts" beside the Flamenco Manager. Workers need Blender 4.2 or later with Rumple
// installed and enabled; so does the Blender that submits: it says which garments there are.

const JOB_TYPE = {
    label: "Rumple Bake",
    description: "Bake wrinkles into clips beside the file",
    settings: [
        { key: "garments", type: "string", required: true, eval: "C.scene.rumple_bake_order",
          description: "What is baked and what rests on what; Rumple says it" },
        { key: "frames", type: "string", required: false, default: "",
          description: "Frame range A-B. Empty: what each garment has" },
        { key: "clip_folder", type: "string", subtype: "dir_path", required: false, default: "",
          description: "Folder of the clips. Empty: what each garment has" },
        { key: "enable_autoexec", type: "bool", required: false, default: false,
          description: "Run Python drivers and scripts of the file" },
        { key: "blendfile", type: "string", required: true, visible: "web",
          description: "Path of the Blend file to bake" },
    ],
};

function rumple(kind, settings, more) {
    let args = ["--command", "rumple", kind, settings.blendfile].concat(more);
    if (settings.frames) args.push("--frames=" + settings.frames);
    if (settings.clip_folder) args.push("--out=" + settings.clip_folder);
    if (settings.enable_autoexec) args.push("--enable-autoexec");
    return author.Command("exec", { exe: "{blender}", args: args });
}

function compileJob(job) {
    const settings = job.settings;
    const garments = JSON.parse(settings.garments);
    if (!garments.length) throw "the scene has no wrinkled objects that can be baked";
    const tasks = {};
    for (const garment of garments) { // each behind those that it rests on
        const task = author.Task("bake " + garment.name, "blender");
        const which = "--object=" + garment.name;
        task.addCommand(rumple("check", settings, [which, "--to-bake"]));
        task.addCommand(rumple("bake", settings, [which, "--resume"]));
        for (const name of garment.needs) {
            if (tasks[name]) task.addDependency(tasks[name]);
        }
        tasks[garment.name] = task;
        job.addTask(task);
    }
}
