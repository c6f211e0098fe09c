(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const canvas = element("scene");
  const gl = canvas.getContext("webgl2", { antialias: false });
  if (!gl) {
    element("failure").hidden = false;
    return;
  }

  const { multiply, cross, dot, normalised, mix, parts, between } = similarities;
  const { pointProgram, shadeProgram, lineProgram, endProgram } = makePrograms(gl);

  const floats = (text) => {
    const raw = atob(text);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    return new Float32Array(bytes.buffer);
  };
  /// A buffer with its vertex arrays: of points, or of lines as pairs of points.
  const upload = (text, numbers) => {
    const values = floats(text);
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    const arrays = (setUp) => {
      const made = gl.createVertexArray();
      gl.bindVertexArray(made);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      setUp();
      return made;
    };
    const attribute = (index, offset, divisor) => {
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, 3, gl.FLOAT, false, 4 * numbers, offset);
      gl.vertexAttribDivisor(index, divisor);
    };
    return {
      count: values.length / numbers,
      points: arrays(() => attribute(0, 0, 0)),
      others: numbers === 6 && arrays(() => attribute(0, 12, 0)),
      lines: numbers === 6 && arrays(() => { attribute(0, 0, 1); attribute(1, 12, 1); }),
    };
  };
  const clouds = { source: upload(data.source.points, 3), target: upload(data.target.points, 3) };
  const kinds = { outliers: upload(data.outliers.lines, 6), inliers: upload(data.inliers.lines, 6) };
  const placements = data.placements.map((placement) => ({ ...placement, parts: parts(placement.matrix) }));

  const colours = {};
  const style = getComputedStyle(document.body);
  const hex = (name) => {
    const text = style.getPropertyValue(name).trim();
    return [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
  };
  for (const name of ["source", "target", "inlier", "outlier", "plain"]) colours[name] = hex("--" + name);
  const lineColour = { inliers: colours.inlier, outliers: data.pose ? colours.outlier : colours.plain };
  const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

  // What is seen.
  const shown = { source: true, target: true, inliers: true, outliers: true };
  const most = Math.max(kinds.inliers.count, kinds.outliers.count, 1);
  let lines = Math.min(most, data.view.lines);
  let size = data.view.point_size;
  const ups = [[0, 0, 1], [0, -1, 0], [0, 1, 0], [1, 0, 0]];
  let up = Math.max(ups.findIndex((axis) => axis.join() === data.view.up.join()), 0);
  let yaw = data.view.yaw, pitch = data.view.pitch;
  let current = 0, from = 0, started = null;
  let focus, reach;
  let framed = true;  // nobody has moved the camera since it showed the whole picture
  const kTurn = 700;  // ms from one placement to the next

  const frame = () => {
    ({ focus, radius: reach } = placements[current]);
    reach = (1.05 * reach) / Math.sin(data.view.field / 2);
    framed = true;
  };

  let targets = null;
  const resize = () => {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(Math.round(canvas.clientWidth * ratio), 1), height = Math.max(Math.round(canvas.clientHeight * ratio), 1);
    if (targets && canvas.width === width && canvas.height === height) return ratio;
    canvas.width = width;
    canvas.height = height;
    if (targets) {
      gl.deleteTexture(targets.colour);
      gl.deleteTexture(targets.depth);
      gl.deleteFramebuffer(targets.buffer);
    }
    const texture = (format) => {
      const made = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
      return made;
    };
    targets = { colour: texture(gl.RGBA8), depth: texture(gl.DEPTH_COMPONENT24), buffer: gl.createFramebuffer() };
    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, targets.colour, 0);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, targets.depth, 0);
    return ratio;
  };

  const axes = () => {
    const z = ups[up];
    const x = Math.abs(z[0]) > 0.5 ? [0, 1, 0] : [1, 0, 0];
    const y = cross(z, x);
    const back = x.map((value, i) => Math.cos(pitch) * (Math.cos(yaw) * value + Math.sin(yaw) * y[i]) + Math.sin(pitch) * z[i]);
    const right = normalised(cross(z, back));
    return { right, above: cross(back, right), back };
  };
  // The middle of the picture lies beside the legend, where there is room.
  const offset = () => {
    const panel = element("panel").getBoundingClientRect();
    return panel.width && canvas.clientWidth > 700 ? panel.right / canvas.clientWidth : 0;
  };
  const camera = (planes) => {
    const { right, above, back } = axes();
    const eye = focus.map((value, i) => value + reach * back[i]);
    const view = [right[0], above[0], back[0], 0, right[1], above[1], back[1], 0, right[2], above[2], back[2], 0,
                  -dot(right, eye), -dot(above, eye), -dot(back, eye), 1];
    const free = canvas.clientWidth * (1 - offset());
    const least = Math.min(free, canvas.clientHeight);
    const scale = 1 / Math.tan(data.view.field / 2);
    const [near, far] = planes;
    const projection = [scale * least / canvas.clientWidth, 0, 0, 0, 0, scale * least / canvas.clientHeight, 0, 0,
                        -offset(), 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
    return multiply(projection, view);
  };

  const draw = (time) => {
    scheduled = false;
    const ratio = resize();
    let t = 1;
    if (started !== null) {
      if (started < 0) started = time;
      const linear = Math.min((time - started) / kTurn, 1);
      t = linear * linear * (3 - 2 * linear);
      if (linear < 1) schedule();
      else started = null;
    }
    const model = t < 1 ? between(placements[from].parts, placements[current].parts, t) : placements[current].matrix;
    if (t < 1 && framed) {
      const a = placements[from], b = placements[current];
      focus = mix(a.focus, b.focus, t);
      reach = (1.05 * (a.radius + (b.radius - a.radius) * t)) / Math.sin(data.view.field / 2);
    } else if (framed) frame();
    const planes = [0.01 * reach, reach + 60 * placements[current].radius];
    const see = camera(planes);
    gl.viewport(0, 0, canvas.width, canvas.height);

    gl.bindFramebuffer(gl.FRAMEBUFFER, targets.buffer);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(pointProgram.made);
    gl.uniformMatrix4fv(pointProgram.uniforms.camera, false, see);
    gl.uniform1f(pointProgram.uniforms.size, size * ratio);
    gl.uniform1f(pointProgram.uniforms.reach, reach);
    for (const name of ["target", "source"]) {
      if (!shown[name]) continue;
      gl.uniformMatrix4fv(pointProgram.uniforms.model, false, name === "source" ? model : identity);
      gl.uniform3fv(pointProgram.uniforms.colour, colours[name]);
      gl.bindVertexArray(clouds[name].points);
      gl.drawArrays(gl.POINTS, 0, clouds[name].count);
    }

    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.disable(gl.DEPTH_TEST);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, targets.depth);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, targets.colour);
    gl.useProgram(shadeProgram.made);
    gl.uniform1i(shadeProgram.uniforms.colours, 0);
    gl.uniform1i(shadeProgram.uniforms.depths, 1);
    gl.uniform2fv(shadeProgram.uniforms.planes, planes);
    gl.uniform1f(shadeProgram.uniforms.step, 1.4 * ratio);
    gl.bindVertexArray(null);
    gl.drawArrays(gl.TRIANGLES, 0, 3);

    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    for (const name of ["outliers", "inliers"]) {
      const count = Math.min(lines, kinds[name].count);
      if (!shown[name] || count === 0) continue;
      const strong = name === "inliers" || !data.pose;
      gl.useProgram(lineProgram.made);
      gl.uniformMatrix4fv(lineProgram.uniforms.camera, false, see);
      gl.uniformMatrix4fv(lineProgram.uniforms.model, false, model);
      gl.uniform2f(lineProgram.uniforms.pixels, canvas.width, canvas.height);
      gl.uniform1f(lineProgram.uniforms.near, planes[0]);
      gl.uniform1f(lineProgram.uniforms.width, (strong ? 1.5 : 1.1) * ratio);
      gl.uniform1i(lineProgram.uniforms.depths, 1);
      gl.uniform4f(lineProgram.uniforms.colour, ...lineColour[name], strong ? 0.8 : 0.4);
      gl.bindVertexArray(kinds[name].lines);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
      if (name !== "inliers") continue;
      gl.useProgram(endProgram.made);
      gl.uniformMatrix4fv(endProgram.uniforms.camera, false, see);
      gl.uniform1f(endProgram.uniforms.size, Math.max(1.6 * size, 4.5) * ratio);
      gl.uniform1i(endProgram.uniforms.depths, 1);
      gl.uniform4f(endProgram.uniforms.colour, ...lineColour[name], 0.9);
      for (const [arrays, matrix] of [[kinds[name].points, model], [kinds[name].others, identity]]) {
        gl.uniformMatrix4fv(endProgram.uniforms.model, false, matrix);
        gl.bindVertexArray(arrays);
        gl.drawArrays(gl.POINTS, 0, count);
      }
    }
    rule();
  };
  let scheduled = false;
  const schedule = () => {
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(draw);
  };

  // A length that is a round number, at the focus of the picture.
  const rule = () => {
    const least = Math.min(canvas.clientWidth * (1 - offset()), canvas.clientHeight);
    const unit = (2 * reach * Math.tan(data.view.field / 2)) / least;
    const step = 10 ** Math.floor(Math.log10(160 * unit));
    const length = [5, 2, 1].map((k) => k * step).find((value) => value <= 160 * unit);
    const bar = element("bar");
    bar.style.width = length / unit + "px";
    bar.style.borderBottom = "2px solid #9aa7b8";
    bar.textContent = Number(length.toPrecision(1)).toString();
  };

  // The legend.
  const number = (value) => value.toString().replace(/\B(?=(\d{3})+$)/g, "\u202f");
  const place = (next, at_once) => {
    if (next < 0 || next >= placements.length) return;
    from = current;
    current = next;
    if (!at_once && from !== current) started = -1;
    [...element("placements").children].forEach((button, i) => button.setAttribute("aria-pressed", i === current));
    element("placement").textContent = data.pose ? placements[current].name : "as given: no pose";
    schedule();
  };
  placements.forEach(({ name }, i) => {
    const button = document.createElement("button");
    button.textContent = name;
    button.addEventListener("click", () => { place(i); button.blur(); });
    element("placements").append(button);
  });
  element("placements").hidden = placements.length < 2;
  if (placements.length < 2) element("placements").style.display = "none";
  const counts = {
    source: data.source.size, target: data.target.size, inliers: data.inliers.size, outliers: data.outliers.size,
  };
  const row = (name) => element(name).parentElement;
  const toggle = (name, on) => {
    shown[name] = on;
    element(name).checked = on;
    schedule();
  };
  for (const [name, count] of Object.entries(counts)) {
    row(name).lastElementChild.textContent = number(count);
    element(name).addEventListener("change", () => toggle(name, element(name).checked));
  }
  if (!data.pose) {
    row("inliers").style.display = "none";
    row("outliers").querySelector("span").textContent = "correspondences";
  }
  const show_lines = () => {
    element("limit").lastElementChild.textContent = lines < most ? `${number(lines)} of each` : "all";
    element("lines").value = most > 1 ? (100 * Math.log(Math.max(lines, 1))) / Math.log(most) : 100;
    schedule();
  };
  const set_lines = (next) => { lines = Math.min(Math.max(Math.round(next), 1), most); show_lines(); };
  element("lines").addEventListener("input", () => set_lines(most ** (element("lines").value / 100)));
  const set_size = (next) => {
    size = Math.min(Math.max(next, 0.5), 8);
    element("size").value = size;
    schedule();
  };
  element("size").addEventListener("input", () => set_size(Number(element("size").value)));
  const hide = (on) => {
    element("panel").classList.toggle("hidden", on);
    element("show").hidden = !on;
    schedule();
  };
  element("show").addEventListener("click", () => hide(false));
  element("hide").addEventListener("click", () => hide(true));
  for (const name of ["lines", "size"]) element(name).addEventListener("change", () => element(name).blur());

  const keys = {
    " ": () => place((current + 1) % placements.length),
    i: () => data.pose && toggle("inliers", !shown.inliers),
    o: () => toggle("outliers", !shown.outliers),
    s: () => toggle("source", !shown.source),
    t: () => toggle("target", !shown.target),
    "[": () => set_lines(lines / 1.5),
    "]": () => set_lines(lines * 1.5 + 1),
    "-": () => set_size(size - 0.25),
    "+": () => set_size(size + 0.25),
    "=": () => set_size(size + 0.25),
    u: () => { up = (up + 1) % ups.length; schedule(); },
    f: () => { frame(); schedule(); },
    h: () => hide(!element("panel").classList.contains("hidden")),
  };
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const action = keys[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  });

  // Mouse and fingers.
  const fingers = new Map();
  const orbit = (dx, dy) => {
    yaw -= 0.006 * dx;
    pitch = Math.min(Math.max(pitch + 0.006 * dy, -1.55), 1.55);
  };
  const pan = (dx, dy) => {
    const { right, above } = axes();
    const least = Math.min(canvas.clientWidth * (1 - offset()), canvas.clientHeight);
    const unit = (2 * reach * Math.tan(data.view.field / 2)) / least;
    focus = focus.map((value, i) => value + unit * (-dx * right[i] + dy * above[i]));
    framed = false;
  };
  const zoom = (factor) => {
    reach = Math.min(Math.max(reach * factor, 1e-3 * placements[current].radius), 40 * placements[current].radius);
    framed = false;
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.max(Math.hypot(a.x - b.x, a.y - b.y), 1) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    canvas.classList.add("moving");
  });
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const before = fingers.size === 2 && spread();
    const dx = event.clientX - finger.x, dy = event.clientY - finger.y;
    finger.x = event.clientX;
    finger.y = event.clientY;
    if (before) {
      const after = spread();
      pan(after.x - before.x, after.y - before.y);
      zoom(before.apart / after.apart);
    } else if (event.shiftKey || (event.buttons & 6) !== 0) pan(dx, dy);
    else orbit(dx, dy);
    schedule();
  });
  for (const name of ["pointerup", "pointercancel"])
    canvas.addEventListener(name, (event) => {
      fingers.delete(event.pointerId);
      if (fingers.size === 0) canvas.classList.remove("moving");
    });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp((event.deltaMode === 1 ? 0.05 : 0.0015) * event.deltaY));
    schedule();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { frame(); schedule(); });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  window.addEventListener("resize", schedule);

  // The placement's name behind # opens the page with it: view.html#before.
  const named = placements.findIndex(({ name }) => name === decodeURIComponent(location.hash.slice(1)));
  if (canvas.clientWidth <= 700) hide(true);  // it would cover the picture
  place(named >= 0 ? named : Math.min(1, placements.length - 1), true);
  frame();
  show_lines();
  set_size(size);
})();
