"use strict";
// Vectors, matrices and similarities of registration_page.js. Its scripts are one behind the other in the page.
const similarities = (() => {
  // Matrices are column-major, as WebGL takes them.
  const multiply = (a, b) => {
    const c = new Float64Array(16);
    for (let column = 0; column < 4; ++column)
      for (let row = 0; row < 4; ++row)
        for (let k = 0; k < 4; ++k) c[4 * column + row] += a[4 * k + row] * b[4 * column + k];
    return c;
  };
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const normalised = (a) => a.map((x) => x / Math.hypot(...a));
  const mix = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);

  /// Scale, unit quaternion and translation of a similarity.
  const parts = (m) => {
    const scale = Math.cbrt(dot(m.slice(0, 3), cross(m.slice(4, 7), m.slice(8, 11))));
    const r = (row, column) => m[4 * column + row] / scale;
    const trace = r(0, 0) + r(1, 1) + r(2, 2);
    let q;
    if (trace > 0) q = [1 + trace, r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)];
    else if (r(0, 0) >= r(1, 1) && r(0, 0) >= r(2, 2))
      q = [r(2, 1) - r(1, 2), 1 + r(0, 0) - r(1, 1) - r(2, 2), r(0, 1) + r(1, 0), r(0, 2) + r(2, 0)];
    else if (r(1, 1) >= r(2, 2))
      q = [r(0, 2) - r(2, 0), r(0, 1) + r(1, 0), 1 + r(1, 1) - r(0, 0) - r(2, 2), r(1, 2) + r(2, 1)];
    else q = [r(1, 0) - r(0, 1), r(0, 2) + r(2, 0), r(1, 2) + r(2, 1), 1 + r(2, 2) - r(0, 0) - r(1, 1)];
    return { scale, q: normalised(q), shift: m.slice(12, 15) };
  };
  /// The similarity a share t of the way from one to another: it turns the source about its middle.
  const between = (a, b, t) => {
    let to = b.q;
    let cosine = a.q.reduce((sum, x, i) => sum + x * to[i], 0);
    if (cosine < 0) {
      to = to.map((x) => -x);
      cosine = -cosine;
    }
    const angle = Math.acos(Math.min(cosine, 1));
    const weight = (u) => (angle < 1e-4 ? u : Math.sin(u * angle) / Math.sin(angle));
    const [w, x, y, z] = normalised(a.q.map((value, i) => weight(1 - t) * value + weight(t) * to[i]));
    const s = a.scale * (b.scale / a.scale) ** t;
    const shift = mix(a.shift, b.shift, t);
    return [
      s * (1 - 2 * (y * y + z * z)), s * 2 * (x * y + w * z), s * 2 * (x * z - w * y), 0,
      s * 2 * (x * y - w * z), s * (1 - 2 * (x * x + z * z)), s * 2 * (y * z + w * x), 0,
      s * 2 * (x * z + w * y), s * 2 * (y * z - w * x), s * (1 - 2 * (x * x + y * y)), 0,
      ...shift, 1,
    ];
  };

  return { multiply, cross, dot, normalised, mix, parts, between };
})();
