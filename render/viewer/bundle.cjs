// node bundle.cjs MODULES FILE: bundles the viewer with what npm installed in MODULES, and writes it as C++ (see
// render/detail/viewer_program.h).
const { readFileSync, writeFileSync } = require("node:fs");
const { createRequire } = require("node:module");
const { join } = require("node:path");
const { deflateSync } = require("node:zlib");

const [modules, file] = process.argv.slice(2);
const esbuild = createRequire(join(modules, "package.json"))("esbuild");
const { outputFiles } = esbuild.buildSync({
  entryPoints: [join(__dirname, "main.js")], nodePaths: [join(modules, "node_modules")], bundle: true, minify: true,
  write: false, format: "iife", target: "es2022", legalComments: "inline",
  banner: { js: `/* three.js:\n${readFileSync(join(modules, "node_modules/three/LICENSE"))}*/` },
});
const text = deflateSync(outputFiles[0].contents, { level: 9 }).toString("base64");
writeFileSync(file, `#include <recede/render/detail/viewer_program.h>

namespace recede::detail {

std::string_view viewer_program() {
  return
${text.match(/.{1,4000}/g).map((chunk) => `    "${chunk}"`).join("\n")};
}

}  // namespace recede::detail
`);
