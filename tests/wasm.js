// node wasm.js PROGRAM: runs a program of tests/firmware/ that was built with port_wasm.c
const fs = require('fs');
const program = new WebAssembly.Module(fs.readFileSync(process.argv[2]));
let memory;
const instance = new WebAssembly.Instance(program, {
    env: {
        show(at) {
            const bytes = new Uint8Array(memory.buffer);
            let end = at;
            while (bytes[end]) end++;
            process.stdout.write(Buffer.from(bytes.slice(at, end)));
        },
    },
});
memory = instance.exports.memory;
process.exitCode = instance.exports.run();
