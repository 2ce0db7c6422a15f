// SPDX-License-Identifier: GPL-3.0-or-later
// What Flamenco Manager lends to a job type, as far as ours uses it: node flamenco_stub.js JOB_TYPE.js SETTINGS
// prints the job type's settings and the tasks that it makes.
const fs = require("fs");
const vm = require("vm");

class Task {
    constructor(name, type) { Object.assign(this, { name, type, commands: [], dependencies: [] }); }
    addCommand(command) { this.commands.push(command); }
    addDependency(task) {
        if (!(task instanceof Task)) throw new Error("a dependency is a task");
        this.dependencies.push(task);
    }
}
const author = {
    Task(name, type) {
        if (!name || !["blender", "ffmpeg", "file-management", "misc"].includes(type)) throw new Error("a task of no type");
        return new Task(name, type);
    },
    Command(name, parameters) {
        if (name !== "exec" || typeof parameters.exe !== "string" || !parameters.args.every(one => typeof one === "string")) {
            throw new Error("exec takes exe, a string, and args, strings");
        }
        return { name, parameters };
    },
};
const job = { name: "a job", settings: JSON.parse(process.argv[3]), tasks: [], addTask(task) { this.tasks.push(task); } };
const globals = vm.createContext({ author, job, print: () => {} });
vm.runInContext(fs.readFileSync(process.argv[2], "utf8") + "\nglobalThis.found = JOB_TYPE; compileJob(job);", globals);
console.log(JSON.stringify({
    settings: globals.found.settings,
    tasks: job.tasks.map(task => ({ name: task.name, commands: task.commands,
                                    dependencies: task.dependencies.map(one => one.name) })),
}));
