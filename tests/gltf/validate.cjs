// Prints what the validator found; fails on errors and warnings.
const fs = require("fs");
const { validateBytes } = require("gltf-validator");

validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 20 }).then(({ issues, info }) => {
  console.log(JSON.stringify({ info, issues }, null, 2));
  process.exit(issues.numErrors + issues.numWarnings > 0 ? 1 : 0);
});
