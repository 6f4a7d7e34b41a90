// The Khronos validator on GLB files: check_glb.cjs FILE …  Errors and warnings fail. Coordinates of a lightmap, which no material uses, are well.
const { readFileSync } = require("node:fs");
const { validateBytes, version } = require("gltf-validator");

(async () => {
  let bad = 0;
  for (const file of process.argv.slice(2)) {
    const { issues, info } = await validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 50, ignoredIssues: ["UNUSED_OBJECT"] });
    for (const m of issues.messages) {
      console.log(`${file}: ${m.code} at ${m.pointer}: ${m.message}`);
    }
    bad += issues.numErrors + issues.numWarnings;
    const { totalVertexCount: v, totalTriangleCount: t, materialCount: m } = info;
    console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${v} vertices, ${t} triangles, ${m} materials`);
    bad += v > 0 && t > 0 ? 0 : 1;
  }
  console.log(`glTF validator ${version()}`);
  process.exit(bad === 0 ? 0 : 1);
})();
