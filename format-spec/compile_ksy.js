// Compile bvhc.ksy to Python: node compile_ksy.js KSY OUT_FOLDER (with kaitai-struct-compiler and js-yaml installed).
const fs = require("fs");
const path = require("path");
const yaml = require("js-yaml");
const compiler = require("kaitai-struct-compiler");

const [source, folder] = process.argv.slice(2);
const importer = { importYaml: (name) => Promise.reject(new Error(`bvhc.ksy imports nothing, but ${name} was asked for`)) };
compiler
  .compile("python", yaml.load(fs.readFileSync(source, "utf8")), importer, false)
  .then((files) => {
    for (const [name, text] of Object.entries(files)) {
      fs.writeFileSync(path.join(folder, name), text);
      console.log(`compiled ${name}`);
    }
  })
  .catch((error) => {
    console.error(`${source} does not compile: ${error.message || error}`);
    process.exit(1);
  });
