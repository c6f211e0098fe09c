// The programs that registration_page.js draws with.
const makePrograms = (gl) => {
  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.bindAttribLocation(made, 0, "a");
    gl.bindAttribLocation(made, 1, "b");
    gl.linkProgram(made);
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); ++i) {
      const { name } = gl.getActiveUniform(made, i);
      uniforms[name] = gl.getUniformLocation(made, name);
    }
    return { made, uniforms };
  };

  const pointProgram = program(
    `in vec3 a; uniform mat4 camera; uniform mat4 model; uniform float size; uniform float reach;
     void main() {
       gl_Position = camera * (model * vec4(a, 1.0));
       gl_PointSize = size * clamp(reach / gl_Position.w, 0.7, 3.0);
     }`,
    `uniform vec3 colour; out vec4 result;
     void main() {
       vec2 p = 2.0 * gl_PointCoord - 1.0;
       if (dot(p, p) > 1.0) discard;
       result = vec4(colour, 1.0);
     }`,
  );
  // Eye-dome lighting (Boucheny 2009): a pixel is the darker the more its neighbours are nearer to the eye.
  const shadeProgram = program(
    `out vec2 at;
     void main() {
       at = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
       gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
     }`,
    `in vec2 at; uniform sampler2D colours; uniform sampler2D depths; uniform vec2 planes; uniform float step;
     out vec4 result;
     float distanceAt(vec2 p) {
       float d = 2.0 * texture(depths, p).r - 1.0;
       return log2(2.0 * planes.x * planes.y / (planes.x + planes.y - d * (planes.y - planes.x)));
     }
     void main() {
       vec4 c = texture(colours, at);
       float centre = distance(at, vec2(0.5));
       vec3 background = mix(vec3(0.086, 0.118, 0.165), vec3(0.035, 0.05, 0.075), smoothstep(0.0, 0.8, centre));
       vec2 pixel = step / vec2(textureSize(depths, 0));
       float here = distanceAt(at), nearer = 0.0;
       for (int k = 0; k < 8; ++k) {
         float angle = float(k) * 0.785398;
         nearer += max(0.0, here - distanceAt(at + pixel * vec2(cos(angle), sin(angle))));
       }
       result = vec4(c.a > 0.0 ? c.rgb * max(exp(-nearer * 6.0), 0.3) : background, 1.0);
     }`,
  );
  const hidden = `uniform sampler2D depths;
     float share() {  // what lies behind points, by a hundredth of the distance or more, shines through
       float depth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
       return gl_FragCoord.z > depth + 0.01 * (1.0 - depth) ? 0.35 : 1.0;
     }`;
  const lineProgram = program(
    `in vec3 a; in vec3 b; uniform mat4 camera; uniform mat4 model; uniform vec2 pixels; uniform float width; uniform float near;
     void main() {
       vec4 p = camera * (model * vec4(a, 1.0)), q = camera * vec4(b, 1.0);
       if (p.w < near) p = mix(p, q, (near - p.w) / max(q.w - p.w, 1e-6 * near));
       if (q.w < near) q = mix(q, p, (near - q.w) / max(p.w - q.w, 1e-6 * near));
       vec2 along = (q.xy / q.w - p.xy / p.w) * pixels;
       vec2 side = length(along) > 1e-6 ? normalize(vec2(-along.y, along.x)) : vec2(0.0, 1.0);
       vec4 end = (gl_VertexID & 2) == 0 ? p : q;
       float sign = (gl_VertexID & 1) == 0 ? -1.0 : 1.0;
       gl_Position = p.w < near || q.w < near ? vec4(2.0, 2.0, 2.0, 1.0) : end + vec4(side * sign * width / pixels * end.w, 0.0, 0.0);
     }`,
    `uniform vec4 colour; out vec4 result; ${hidden}
     void main() { result = vec4(colour.rgb, colour.a * share()); }`,
  );
  const endProgram = program(
    `in vec3 a; uniform mat4 camera; uniform mat4 model; uniform float size;
     void main() { gl_Position = camera * (model * vec4(a, 1.0)); gl_PointSize = size; }`,
    `uniform vec4 colour; out vec4 result; ${hidden}
     void main() {
       float r = length(2.0 * gl_PointCoord - 1.0);
       if (r > 1.0) discard;
       result = vec4(colour.rgb, colour.a * share() * (1.0 - smoothstep(0.8, 1.0, r)));
     }`,
  );

  return { pointProgram, shadeProgram, lineProgram, endProgram };
};
