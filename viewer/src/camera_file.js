// A camera for `zonal render`: a file for --camera-file, or options of the command line.
//
// A camera is { origin, target, up, fov } in the coordinates of the scene; fov is the angle across the width of the picture, degrees.

/** A number with nine significant digits, as TOML and the command line read it. */
const number = (x) => String(Number(x.toPrecision(9)) + 0);
const list = (v) => v.map(number).join(', ');

/** The text of a camera file. */
export function cameraFile({ origin, target, up, fov }) {
  return `# zonal render RUN.npz --camera-file camera.toml -o picture.png
[[camera]]
name = "view"
origin = [${list(origin)}]
target = [${list(target)}]
up = [${list(up)}]
fov = ${number(fov)}
`;
}

/** The options of the command line. */
export function cameraOptions({ origin, target, up, fov }) {
  const point = (v) => v.map(number).join(',');
  const upright = up[0] === 0 && up[1] === 0 && up[2] > 0;
  return `--from ${point(origin)} --look-at ${point(target)} --fov ${number(fov)}${upright ? '' : ` --up ${point(up)}`}`;
}

/** Downloads a text as a file. */
export function save(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: 'text/plain' }));
  Object.assign(document.createElement('a'), { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

/** Copies a text; false where the browser does not allow it. */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false;
  }
}
