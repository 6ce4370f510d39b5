// Oracle for test_onnx.c: runs a model in ONNX Runtime (npm install onnxruntime-node, found by
// NODE_PATH). Arguments and files as those of onnx_numpy.py. Exit status 77: it is not here.
'use strict';
const fs = require('fs');
let ort;
try {
    ort = require('onnxruntime-node');
} catch (_) {
    process.exit(77);
}

// [n, h, w, c] to [n, c, h, w], and back with `back`.
function turn(data, n, c, size, back) {
    const out = new Float32Array(data.length);
    for (let i = 0; i < n; ++i)
        for (let k = 0; k < c; ++k)
            for (let p = 0; p < size; ++p) {
                const nhwc = (i * size + p) * c + k, nchw = (i * c + k) * size + p;
                out[back ? nhwc : nchw] = data[back ? nchw : nhwc];
            }
    return out;
}

async function main(model, inPath, outPath, viewChannels, n, h, w) {
    const session = await ort.InferenceSession.create(
        model, {intraOpNumThreads: 1, interOpNumThreads: 1, executionProviders: ['cpu']});
    const bytes = fs.readFileSync(inPath);
    const all = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
    const views = viewChannels * h * w, lights = all.length - views;
    const channels = lights / (n * h * w);
    const feeds = {};
    if (session.inputNames.includes('view_input'))
        feeds.view_input = new ort.Tensor(
            'float32', turn(all.subarray(0, views), 1, viewChannels, h * w, false), [1, viewChannels, h, w]);
    if (session.inputNames.includes('light_input'))
        feeds.light_input = new ort.Tensor(
            'float32', turn(all.subarray(views), n, channels, h * w, false), [n, channels, h, w]);
    const results = await session.run(feeds);
    const parts = session.outputNames.map((name) => {
        const [m, c, y, x] = results[name].dims;
        return Buffer.from(turn(results[name].data, m, c, y * x, true).buffer);
    });
    fs.writeFileSync(outPath, Buffer.concat(parts));
}

const [model, inPath, outPath, ...sizes] = process.argv.slice(2);
main(model, inPath, outPath, ...sizes.map(Number)).catch((e) => {
    console.error(e.message);
    process.exit(1);
});
