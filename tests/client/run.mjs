// node run.mjs MODULE.wasm                  run the tests in a module that `cargo test` compiled
// node run.mjs MODULE.wasm RAYS FILE...     what rays hit in each file, as the native program prints it
import { readFileSync } from "node:fs";

const [path, rays, ...files] = process.argv.slice(2);
const { exports } = new WebAssembly.Instance(new WebAssembly.Module(readFileSync(path)), {});

// Without arguments from outside every test is run, on one thread. The target has no output: a test that fails stops the module, and
// the names of the functions then on the stack say which it was.
if (rays === undefined) {
    process.exit(exports.main(0, 0));
}
for (const file of files) {
    const bytes = readFileSync(file);
    const place = exports.file(bytes.length); // Memory may move by this, so it is looked up afterwards.
    new Uint8Array(exports.memory.buffer, place, bytes.length).set(bytes);
    const length = exports.trace(Number(rays));
    process.stdout.write(`== ${file}\n`);
    process.stdout.write(Buffer.from(new Uint8Array(exports.memory.buffer, exports.text(), length)));
}
