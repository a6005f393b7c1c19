// node validate_gltf.cjs NODE_MODULES FILE...
// Runs Khronos' glTF validator: a line for each error and warning, exit status 1 when there are errors.
const fs = require('fs');
const path = require('path');

const [modules, ...files] = process.argv.slice(2);
const validator = require(path.join(path.resolve(modules), 'gltf-validator'));

async function main() {
  let errors = 0;
  for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
      uri: path.basename(file),
      externalResourceFunction: async (uri) =>
          new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri)))),
    });
    for (const message of report.issues.messages) {
      if (message.severity > 1) continue;
      console.log(`${file}: ${message.severity === 0 ? 'error' : 'warning'} ${message.code} at ` +
                  `${message.pointer ?? message.offset}: ${message.message}`);
    }
    errors += report.issues.numErrors;
  }
  process.exitCode = errors > 0 ? 1 : 0;
}

main();
