// Follows the solve behind a page: its progress, and new data when there are some.

/** Milliseconds between two questions, during a solve and after it. */
const INTERVAL = { busy: 500, idle: 2000 };

const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/** The progress of the solve; null where no server answers or it does not solve. */
export async function progress() {
  try {
    const response = await fetch('progress.json');
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}

/** One line about a solve in progress; empty when it is done. */
export function describe(p) {
  if (p.error) return `Not solved: ${p.error}`;
  if (p.done) return '';
  const stage = p.stage ? `${p.stage} ${Math.round(100 * p.fraction)} %` : 'starting';
  return `Solving (${p.quality}): ${stage}`;
}

/** Waits for the first data and reports the progress meanwhile. Returns the last progress. */
export async function waitForData(show) {
  for (;;) {
    const p = await progress();
    if (!p || p.version > 0 || p.error) return p;
    show(p);
    await wait(INTERVAL.busy);
  }
}

/**
 * Follows the solves from data of a version on, until the server ends. `show` gets the line about the solve, `replace` is called when there are new data and
 * returns a promise; a version whose data cannot be shown is not tried again.
 */
export async function follow(version, show, replace) {
  for (let current = version; ;) {
    const p = await progress();
    if (!p) return show('The server has ended; the page shows its last data.');
    show(describe(p));
    if (p.version > current) {
      current = p.version;
      await replace();
    }
    await wait(p.done ? INTERVAL.idle : INTERVAL.busy);
  }
}

/** True if data have the parts on which the controls depend: the page keeps its state when they are replaced. */
export function isSameScene(a, b) {
  const names = (data) => JSON.stringify([data.name, data.groups.map((g) => g.name), data.cameras, data.origin, data.bounds]);
  return names(a) === names(b) && !a.volume === !b.volume;
}
