// Polished and brushed metal lit by the room and the lamp. Include after lighting.glsl.

// Reflection of the room in polished metal: bright and dark bands, which are typical of metal.
vec3 metal_room(vec3 r, float rough) {
  float up = dot(r, frame.up.xyz), side = dot(r, frame.window.xyz);
  float soft = 0.10 + 0.6 * rough;
  vec3 color = mix(vec3(0.10, 0.09, 0.085), vec3(0.55, 0.58, 0.62), smoothstep(-soft - 0.3, soft, up));
  color += vec3(0.9, 0.93, 1.0) * smoothstep(0.30 - soft, 0.30 + 0.5 * soft, side) * smoothstep(0.95 + soft, 0.75, side);
  color += vec3(0.5, 0.49, 0.47) * smoothstep(0.55 - soft, 0.60 + soft, -side) * 0.6;
  return color + room(r, rough) * 0.6;
}

// factor of the room's light; it keeps the bright bands below white, so that they show the shape
const float kRoomOnMetal = 0.62;

/// Returns the light that metal with fine grooves along `groove` reflects at p. `brushed`: 0 isotropic, 1 strongest;
/// `widened`: squared width from the change of the normal within a pixel; `key`: visible fraction of the lamp.
vec3 brushed_metal(vec3 p, vec3 n, vec3 v, vec3 groove, float brushed, float rough, float widened, vec3 albedo,
                   float key) {
  vec3 across = cross(n, groove), l = frame.key.xyz, around = vec3(0.0);
  float a = max(rough * rough, 0.02), thin = a * (1.0 - 0.6 * brushed), wide = min(a * (1.0 + 4.0 * brushed), 1.0);
  if (kLightGrid) {
    // Mean of three directions, which the grooves spread.
    around = mirrored_light(p, n, reflect(-v, n), kMirrorAtMetal);
    if (brushed > 0.0) {
      vec3 tilt = 0.9 * (wide - thin) * across;
      around = 0.5 * around + 0.25 * (mirrored_light(p, n, reflect(-v, normalize(n - tilt)), kMirrorAtMetal) +
                                      mirrored_light(p, n, reflect(-v, normalize(n + tilt)), kMirrorAtMetal));
    }
  } else {
    // Reflection of the room by a normal that is bent towards the viewer (Revie 2011).
    vec3 bent = normalize(mix(n, cross(cross(groove, v), groove), 0.8 * brushed));
    around = kRoomOnMetal * metal_room(reflect(-v, bent), rough);
  }
  // Reflection of the lamp: anisotropic GGX distribution (Burley 2012).
  float lamp = 0.25 * kLampHalfAngle;  // the lamp's size makes its image wider (Karis 2013)
  thin = sqrt(thin * thin + widened + lamp * lamp);
  wide = min(sqrt(wide * wide + (1.0 - brushed) * widened + lamp * lamp), 1.0);
  vec3 h = normalize(l + v);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 0.05), k = 0.5 * sqrt(thin * wide);
  float x = dot(groove, h) / thin, y = dot(across, h) / wide, z = dot(n, h), d = x * x + y * y + z * z;
  float vis = 0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
  float image = vis / (kPi * thin * wide * d * d);
  // Without a grid of light, a constant fraction of the lamp's light replaces the light that nearby surfaces reflect.
  return albedo * (around + key * frame.key.w * nl * ((kLightGrid ? 0.0 : 0.10) + image));
}
