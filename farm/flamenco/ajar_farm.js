// SPDX-License-Identifier: GPL-3.0-or-later
// A job type of Flamenco 3: frames are divided into parts of their samples, and the parts are merged. Copy it into the folder "scripts" beside the Flamenco Manager.
// It is written by the rules of Flamenco's manual (job types, https://flamenco.blender.org/usage/job-types/) and was never run in a Flamenco Manager.
//
// Needs two variables of the manager: `ajarRender`, the program ajar-render on the workers, and `blender`. It uses the command `exec` of Flamenco 3.5 or newer.
const JOB_TYPE = {
  label: "Ajar: samples divided among workers",
  settings: [
    { key: "frames", type: "string", required: true, eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'", description: "Frames, such as 1-250 or 1,5,9" },
    { key: "split", type: "int32", default: 4, description: "Parts of each frame" },
    { key: "samples", type: "int32", default: 256, description: "Samples per pixel of each frame" },
    { key: "seed", type: "int32", default: 0, description: "The same seed gives the same image" },
    { key: "options", type: "string", default: "", description: "Further options of ajar-render, separated by spaces" },
    { key: "job_folder", type: "string", subtype: "dir_path", required: true, description: "A folder that all workers see" },
    { key: "blendfile", type: "string", required: true, visible: "web", description: "The file that is rendered" },
  ],
};

function compileJob(job) {
  const settings = job.settings;
  const options = settings.options.split(" ").filter((option) => option !== "");
  for (const chunk of frameChunker(settings.frames, 1)) compileFrame(job, settings, Number(chunk), options);
}

function compileFrame(job, settings, frame, options) {
  const number = String(frame).padStart(4, "0");
  const scene = path.join(settings.job_folder, `${number}.ajar`);

  const dump = author.Task(`scene-${number}`, "blender");
  dump.addCommand(author.Command("exec", {
    exe: "{blender}",
    args: ["-b", settings.blendfile, "--addons", "ajar_render", "-E", "AJAR", "-o", path.join(settings.job_folder, "unused-####"), "-F", "PNG", "-f", String(frame),
           "--", "--ajar-dump-scene", scene, "--ajar-dump-only", "on"],
  }));
  job.addTask(dump);

  const checkpoints = [];
  const merge = author.Task(`merge-${number}`, "file-management");
  for (let part = 0; part < settings.split; part++) {
    const first = Math.floor((settings.samples * part) / settings.split), end = Math.floor((settings.samples * (part + 1)) / settings.split);
    if (end === first) continue;
    const base = path.join(settings.job_folder, `${number}-${part}`);
    const render = author.Task(`render-${number}-${part}`, "blender");
    // Flamenco runs a task again if its worker fails: it then goes on from the checkpoint.
    render.addCommand(author.Command("exec", {
      exe: "{ajarRender}",
      args: [scene, `${base}.exr`, "--continue", `${base}.checkpoint`, "--seed", String(settings.seed), "--first-sample", String(first),
             "--seconds", "0", "--error", "0", "--samples", String(end - first)].concat(options),
    }));
    render.addDependency(dump);
    job.addTask(render);
    merge.addDependency(render);
    checkpoints.push(`${base}.checkpoint`);
  }
  merge.addCommand(author.Command("exec", {
    exe: "{ajarRender}",
    args: ["--merge", path.join(settings.job_folder, `${number}.exr`), path.join(settings.job_folder, `${number}.checkpoint`)].concat(checkpoints),
  }));
  job.addTask(merge);
}
