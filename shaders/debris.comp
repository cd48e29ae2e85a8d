#version 460
// Computes one step of all particles that are stored on the GPU, by the physics of engine/debris (motion.h,
// Debris::State::update_fully). Every particle gets a full update in every step. The shader also writes the instances
// for drawing.
layout(local_size_x = 64) in;

struct Particle {
  vec4 place;   // xyz: position, m, W; w: age, s
  vec4 motion;  // xyz: velocity, m/s; w: initial mass, kg, 0: removed
  vec4 chip;  // x: diameter, m; y: density, kg/m³; z: drag rate, 1/s, kStuck at rest; w: colour, bytes
};
layout(set = 0, binding = 0, std430) buffer Particles { Particle particles[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Instances { uint instances[]; };  // 5 words per instance
// m, samples of the distance field
layout(set = 0, binding = 2, std430) readonly buffer Field { float field[]; };
layout(push_constant) uniform Step {
  vec4 gravity;  // xyz: m/s²; w: length of the step, s
  vec4 origin;  // xyz: origin of the field, m; w: its spacing, m
  ivec4 size;  // xyz: number of field samples; w: capacity for particles
  vec4 sink;  // xyz: position of the nozzle, m; w: strength of suction, m³/s/sr, 0: no suction
  vec4 air;  // x: density, kg/m³; y: viscosity, Pa·s; z: radius of the nozzle, m; w: decay time of the mass, s
  vec4 bounce;  // speed ratios of a bounce, x: normal, y: tangential; z: smallest drawn diameter, m; w: lifetime, s
  uvec4 ring;  // x: index of the oldest particle; y: number of particles; z: unused
};

const float kStuck = 1e30, kRestSpeed = 0.05, kPi = 3.14159265;

// Computes the drag rate from the drag coefficient C_d = 24/Re (1 + 0.15 Re^0.687) for Re < 1000 (Schiller & Naumann
// 1933), 0.44 above.
float drag_rate(float speed, float diameter, float density) {
  float stokes = 18.0 * air.y / (density * diameter * diameter), re = air.x * speed * diameter / air.y;
  if (re >= 1000.0) return stokes * 0.44 * re / 24.0;
  return re < 1e-6 ? stokes : stokes * (1.0 + 0.15 * pow(re, 0.687));
}

// Computes the distance and its gradient, interpolated linearly between the samples. Returns false outside the field.
bool look(vec3 p, out float d, out vec3 g) {
  vec3 q = (p - origin.xyz) / origin.w, low = floor(q), f = q - low;
  ivec3 i = ivec3(low);
  d = 0.0;
  g = vec3(0.0);
  if (size.x == 0 || any(lessThan(i, ivec3(0))) || any(greaterThanEqual(i, size.xyz - 1))) return false;
  int sy = size.z, sx = sy * size.y, at = i.x * sx + i.y * sy + i.z;
  float d000 = field[at], d001 = field[at + 1], d010 = field[at + sy], d011 = field[at + sy + 1];
  float d100 = field[at + sx], d101 = field[at + sx + 1], d110 = field[at + sx + sy], d111 = field[at + sx + sy + 1];
  float x00 = mix(d000, d100, f.x), x01 = mix(d001, d101, f.x), x10 = mix(d010, d110, f.x), x11 = mix(d011, d111, f.x);
  float y0 = mix(x00, x10, f.y), y1 = mix(x01, x11, f.y);
  d = mix(y0, y1, f.z);
  g = vec3(mix(mix(d100 - d000, d110 - d010, f.y), mix(d101 - d001, d111 - d011, f.y), f.z),
           mix(x10 - x00, x11 - x01, f.z), y1 - y0) / origin.w;
  return true;
}

// Returns the smallest distance between the point c and the segment from a to b.
float passes(vec3 a, vec3 b, vec3 c) {
  vec3 way = b - a;
  return length(c - a - clamp(dot(c - a, way) / max(dot(way, way), 1e-20), 0.0, 1.0) * way);
}

// Returns the mean velocity of the air in one step. The air does not move beyond the nozzle (engine/debris/motion).
vec3 suction_velocity(vec3 p) {
  vec3 d = sink.xyz - p;
  float near = inversesqrt(dot(d, d) + 1e-12), pull = sink.w * near * near * near, dt = gravity.w;
  return (pull * dt < 1.0 / 3.0 ? pull * (1.0 + 2.0 * dt * pull) : 1.0 / dt) * d;
}

// Writes the instance for drawing. The finest dust is drawn as mist, as in engine/app/picture/debris_view.cpp.
void show(uint s, vec3 p, float diameter, float chip, float bytes) {
  bool mist = chip < 12e-6;
  float fraction = diameter > 0.0 ? min(1.0, diameter / bounce.z) * (mist ? 0.16 : 1.0) : 0.0;
  uint color = floatBitsToUint(bytes) & 0x00ffffffu;
  instances[5 * s + 0] = floatBitsToUint(p.x);
  instances[5 * s + 1] = floatBitsToUint(p.y);
  instances[5 * s + 2] = floatBitsToUint(p.z);
  instances[5 * s + 3] = floatBitsToUint(diameter > 0.0 ? 0.5 * max(diameter, bounce.z) * (mist ? 2.5 : 1.0) : 0.0);
  instances[5 * s + 4] = color | (uint(fraction * 255.0 + 0.5) << 24);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= ring.y) return;
  uint s = ring.x + i;
  if (s >= uint(size.w)) s -= uint(size.w);
  Particle own = particles[s];
  vec3 p = own.place.xyz, v = own.motion.xyz;
  float dt = gravity.w, rate = own.chip.z, diameter = own.chip.x, mass = own.motion.w;
  own.place.w += dt;
  if (rate < 0.0) rate = drag_rate(length(v), diameter, own.chip.y);  // a new particle has a negative rate
  bool resting = rate >= kStuck;
  vec3 before = p;
  if (!resting) {
    float keep = 1.0 / (1.0 + rate * dt);
    if (sink.w != 0.0) {
      v += (1.0 - keep) / keep * suction_velocity(p);
    }
    v = (v + gravity.xyz * dt) * keep;
    p += v * dt;
  }
  if (sink.w != 0.0 && passes(before, p, sink.xyz) < air.z) {
    mass = 0.0;
    v = vec3(0.0);
    rate = kStuck;
  } else if (mass > 0.0) {
    float d;
    vec3 g;
    bool inside = look(p, d, g);
    bool stays = resting && inside && d < 0.5 * origin.w;
    if (!resting && inside && d < 0.5 * diameter) {
      float steep = length(g);
      vec3 n = steep > 1e-9 ? g / steep : vec3(0.0, 0.0, 1.0);
      p += (0.5 * diameter - d) * n;
      float approach = dot(v, n);
      if (approach < 0.0) v = bounce.y * (v - approach * n) - bounce.x * approach * n;
      stays = dot(v, v) < kRestSpeed * kRestSpeed;
    }
    if (stays) v = vec3(0.0);
    // Drag depends on the speed relative to the air, and suction moves the air.
    vec3 slip = sink.w != 0.0 ? v - suction_velocity(p) : v;
    rate = stays ? kStuck : drag_rate(length(slip), diameter, own.chip.y);
  }
  own.place.xyz = p;
  own.motion = vec4(v, mass);
  own.chip.z = rate;
  particles[s] = own;
  float volume = mass * exp(-own.place.w / air.w) / own.chip.y;
  show(s, p, volume > 0.0 ? pow(6.0 / kPi * volume, 1.0 / 3.0) : 0.0, diameter, own.chip.w);
}
