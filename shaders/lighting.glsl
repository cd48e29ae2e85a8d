// Incident light (shadow, occlusion) and reflected light (appearance) at a point. All computations use frame W, so that
// a mirrored picture needs no special case.

const float kPi = 3.14159265;
// m, limits of the half width of the penumbra of the lamp's shadow. A wider penumbra would need more shadow lookups,
// because each lookup is visible as a step of brightness.
const float kNarrowest = 0.15e-3, kWidest = 0.6e-3;
// kUsualHeight: m, assumed height of the tissue that hides the lamp. kUsualWeight: weight of this height in the mean of
// it and the heights that the shadow lookups find.
const float kUsualHeight = 2.5e-3, kUsualWeight = 0.5;
// smallest cosine of the angle between normal and lamp for which a shadow lookup follows the tangent plane
const float kMinFacing = 0.3;
// A surface shadows a point beside it only if its height above the point is larger than this factor times its distance
// from the point. So concave edges that face the lamp are not dark.
const float kContact = 2.0;
const float kOcclusionRadius = 2.2e-3;  // m, radius in which ambient occlusion is sampled

// Fraction of the grid's light that the wet film reflects where nearby tissue hides the whole room.
const float kNearMirrored = 0.2;

// Cosine beyond which translucent tissue that is turned away from the lamp is dark, and brightening of its half shadow;
// fitted likewise. Only used without a grid of light.
const float kWrap = 0.03, kSoftShadow = 0.15;
// Limits of the roughness between which a surface reflects the light of the mirrored direction, and the light of all
// directions in front of it.
const float kMirrors = 0.3, kSpreads = 0.8;

// Mean irradiance of nearby tissue, relative to tissue that faces the lamp; fitted to the pictures of tests/reference.
const float kBounce = 0.75;

// Returns points that are distributed evenly over the unit disc (Vogel's spiral).
vec2 disc(int i, int count) {
  float r = sqrt((float(i) + 0.5) / float(count));
  float a = 2.39996323 * float(i);
  return r * vec2(cos(a), sin(a));
}

const float kShadowScatter = 1.4e-3;  // m, widening of a shadow's edge in wax; same value as in passes/changed.cpp
const float kToolShadowReach = 25e-3;  // m, longest tool shadow; same value as in passes/changed.cpp

// Returns the fraction of the lamp's light that passes a round body. `way`: distance along the ray to the lamp; `miss`:
// distance of the ray from the body's middle; `reach`: longest shadow; `scatter`: see shadow_scatter().
float passes(float way, float miss, float radius, float reach, float scatter) {
  // m, half width of the penumbra, which grows with the distance from the body
  float soft = 0.08e-3 + frame.lamp.x * max(way, 0.0) + scatter;
  // A body that is thinner than the penumbra hides only a part of the lamp.
  float hidden = smoothstep(-soft, soft, radius - miss) - smoothstep(-soft, soft, -radius - miss);
  return 1.0 - hidden * smoothstep(0.0, radius, way) * (1.0 - smoothstep(0.5 * reach, reach, way));
}

// Shadow of the tool. The tool is approximated by a ball and a cylinder about its axis.
float tool_shadow(vec3 p, float scatter) {
  if (frame.tool_head.w <= 0.0) return 1.0;
  vec3 l = frame.key.xyz, a = frame.tool_head.xyz, d = frame.tool_end.xyz - a, c = a - p;
  float t = dot(c, l);
  float head = passes(t, length(c - t * l), frame.tool_head.w, kToolShadowReach, scatter);
  // Finds the point of the cylinder that is nearest to the ray.
  float dd = dot(d, d), dl = dot(d, l), across = dd - dl * dl;
  float s = across > 1e-12 ? clamp((dl * t - dot(d, c)) / across, 0.0, 1.0) : 0.0;
  vec3 k = c + s * d;
  float way = dot(k, l);
  return min(head, passes(way, length(k - way * l), frame.tool_end.w, kToolShadowReach, scatter));
}

const float kHandpieceReach = 40e-3;  // m, longest handpiece shadow; same value as in passes/changed.cpp

// Returns the fraction of the lamp's light that passes a round cone (a sphere with changing radius that is swept from a
// to b).
float passes_cone(vec3 p, vec4 a, vec4 b, float scatter) {
  vec3 l = frame.key.xyz, c = a.xyz - p, d = b.xyz - a.xyz;
  float dd = dot(d, d), dl = dot(d, l), across = dd - dl * dl;
  float s = across > 1e-12 ? clamp((dl * dot(c, l) - dot(d, c)) / across, 0.0, 1.0) : 0.0;
  vec3 k = c + s * d;
  float way = dot(k, l);
  return passes(way, length(k - way * l), mix(a.w, b.w, s), kHandpieceReach, scatter);
}

float handpiece_shadow(vec3 p, float scatter) {
  if (!kHandpieceShadow) return 1.0;
  return passes_cone(p, frame.handpiece[0], frame.handpiece[1], scatter) *
         passes_cone(p, frame.handpiece[2], frame.handpiece[3], scatter);
}

// Returns the light of the lamp's rectangular spot: 1 inside, 0 outside, with a soft border.
float spot_light(vec3 p) {
  if (!kSpot) return 1.0;
  vec3 q = p - frame.lamp_middle.xyz;
  vec2 at = abs(vec2(dot(q, frame.lamp_right.xyz), dot(q, cross(frame.key.xyz, frame.lamp_right.xyz))));
  vec2 lit = 1.0 - smoothstep(vec2(-0.5), vec2(0.5), (at - frame.lamp.zw) / frame.lamp.y);
  return lit.x * lit.y;
}

// m, at a larger distance the tool causes no ambient occlusion; same value as in passes/changed.cpp
const float kToolReach = 3.0e-3;

float fading(float d2) {
  float f = clamp(1.0 - d2 / (kToolReach * kToolReach), 0.0, 1.0);
  return f * f;
}

// Ambient occlusion near the tool by its head and its shank, each computed by Quilez's formula for a sphere.
float tool_occlusion(vec3 p, vec3 n) {
  if (frame.tool_head.w <= 0.0) return 1.0;
  vec3 c = frame.tool_head.xyz - p;
  float r = frame.tool_head.w, d2 = max(dot(c, c), r * r);
  float head = max(dot(n, c), 0.0) / sqrt(d2) * r * r / d2 * fading(d2);
  vec3 axis = frame.tool_end.xyz - frame.tool_head.xyz;
  float s = clamp(-dot(c, axis) / dot(axis, axis), 0.0, 1.0);
  vec3 k = c + s * axis;
  float q = frame.tool_end.w, k2 = max(dot(k, k), q * q);
  float shank = max(dot(n, k), 0.0) / sqrt(k2) * q / sqrt(k2) * fading(k2);
  return clamp(1.0 - 0.8 * head - 0.35 * shank, 0.0, 1.0);
}

/// Returns the light from the room and from other surfaces that a surface at p with the normal n receives. xyz:
/// irradiance divided by π; w: fraction of the lamp that is visible. Same computation as light_at() in
/// engine/render/light_scene.cpp.
vec4 grid_light(vec3 p, vec3 n) {
  // The samples are read half a cell in front of the surface, because samples behind the surface are inside the body.
  vec3 end = frame.light_samples.xyz - 1.0;
  vec3 q = clamp((p - frame.light_origin.xyz) * frame.light_origin.w + 0.5 * n, vec3(0.0), end) + 0.5;
  // The first axis of the image is z. Along its third axis, the grids of the 6 faces follow one after the other.
  vec3 size = vec3(frame.light_samples.zy, float(kLightDirections) * frame.light_samples.x), weight = n * n;
  vec3 face = vec3(n.x < 0.0 ? 1.0 : 0.0, n.y < 0.0 ? 3.0 : 2.0, n.z < 0.0 ? 5.0 : 4.0) * frame.light_samples.x + q.x;
  return weight.x * textureLod(light_grid, vec3(q.zy, face.x) / size, 0.0) +
         weight.y * textureLod(light_grid, vec3(q.zy, face.y) / size, 0.0) +
         weight.z * textureLod(light_grid, vec3(q.zy, face.z) / size, 0.0);
}

// Distance in front of a surface, in grid spacings, at which the light is read that the surface reflects like a mirror.
// It is smaller at tissue, because tissue often reflects tissue close beside it.
const float kMirrorAtMetal = 0.5, kMirrorAtTissue = 0.2;

/// Returns the light from the direction r that a smooth surface with the normal n mirrors at p. `ahead`: kMirrorAtMetal
/// or kMirrorAtTissue. mirrored_at() in engine/render/light_scene.cpp computes the same with kMirrorAtMetal.
vec3 mirrored_light(vec3 p, vec3 n, vec3 r, float ahead) {
  vec3 end = frame.light_samples.xyz - 1.0;
  vec3 q = clamp((p - frame.light_origin.xyz) * frame.light_origin.w + ahead * n, vec3(0.0), end) + 0.5;
  // Octahedral map (Engelhardt & Dachsbacher 2008), whose outer nodes lie on the edge of the square.
  vec3 o = r / (abs(r.x) + abs(r.y) + abs(r.z));
  vec2 folded = (1.0 - abs(o.yx)) * vec2(o.x < 0.0 ? -1.0 : 1.0, o.y < 0.0 ? -1.0 : 1.0);
  vec2 at = (0.5 + 0.5 * (o.z < 0.0 ? folded : o.xy)) * float(kImageSide - 1);
  vec2 low = min(floor(at), float(kImageSide - 2)), f = at - low;
  // The nodes of the map follow one after the other along the first two axes of the image.
  vec2 samples = frame.light_samples.zy, first = q.zy + low.yx * samples;
  vec3 size = vec3(samples * float(kImageSide), frame.light_samples.x);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i) {
    vec2 next = vec2(i & 1, i >> 1);
    vec2 weight = mix(1.0 - f.yx, f.yx, next);
    sum += weight.x * weight.y * textureLod(mirrored_images, vec3(first + next * samples, q.x) / size, 0.0).rgb;
  }
  return sum;
}

/// Returns the light that has travelled inside the tissue and leaves it at p, or that arrives at an opaque body. xyz:
/// this light divided by the tissue's reflectance; w: fraction of it that came directly from the lamp.
vec4 light_in_tissue(vec3 p) {
  vec3 q = (p - frame.tissue_light_origin.xyz) * frame.tissue_light_origin.w + 0.5;
  return textureLod(tissue_light, (q / frame.tissue_light_cells.xyz).zyx, 0.0);
}
/// Returns 1 where the grid of the light inside tissue has light, and 0 outside the grid, with a soft border.
float in_tissue_grid(vec3 p) {
  const float border = 5.0;  // cells, width of the soft border
  vec3 q = (p - frame.tissue_light_origin.xyz) * frame.tissue_light_origin.w;
  vec3 inner = min(q, frame.tissue_light_cells.xyz - 1.0 - q);
  return smoothstep(0.0, border, min(inner.x, min(inner.y, inner.z)));
}

// Compares a lookup of the shadow map with the depth of the tangent plane at its place. With the depth of the point
// itself, the side of a tilted surface that is nearer to the lamp would shadow the point.
float shadow_lookup(vec3 q, vec2 tilt, float penumbra, int i) {
  vec2 o = penumbra * disc(i, kShadowTaps);
  float down = (dot(tilt, o) - kContact * length(o)) / frame.light_size.y;
  return textureLod(shadow_map, q + vec3(o / frame.light_size.x, down), 0.0);
}

// Returns x: fraction of the lamp's light that arrives; y: fraction of the ambient light. Considers only tissue; the
// tool is computed separately. `beyond`: fraction of the lamp's light beyond the border of the shadow map.
vec2 tissue_visibility(vec3 p, vec3 n, float beyond) {
  vec2 result = vec2(beyond, 1.0);
  if (frame.light_size.w > 0.0) {
    // Ambient occlusion is computed in the lamp's space, where the shadow map is a height field. So it is equal for
    // both eyes and changes only with the tissue. It uses the directions to the samples relative to the normal.
    vec3 n_light = normalize((frame.light_from_world * vec4(n, 0.0)).xyz *
                             vec3(frame.light_size.x, frame.light_size.x, frame.light_size.y));
    vec3 base = (frame.light_from_world * vec4(p + n * frame.light_size.z, 1.0)).xyz;
    // depth of the tangent plane per distance from the point, m / m
    vec2 tilt = n_light.xy / max(-n_light.z, kMinFacing);
    float shut = 0.0;
    // The same samples give the mean height of the tissue that hides a part of the lamp.
    vec2 hiding = vec2(kUsualHeight, 1.0) * kUsualWeight;
    for (int i = 0; i < kOcclusionTaps; ++i) {
      vec2 o = disc(i, kOcclusionTaps) * kOcclusionRadius;
      float z = textureLod(shadow_depth, base.xy + o / frame.light_size.x, 0.0).r;
      vec3 v = vec3(o, (z - base.z) * frame.light_size.y);
      float far2 = dot(v, v), rise = dot(n_light, v), nearness = inversesqrt(far2 + 1e-12);
      shut += max(rise * nearness - 0.08, 0.0) * (1.0 / (1.0 + far2 / (2.0 * kOcclusionRadius * kOcclusionRadius)));
      float height = dot(tilt, o) - v.z;
      hiding += step(kContact * length(o), height) * vec2(height, 1.0);
    }
    result.y = clamp(1.0 - 1.6 * shut / float(max(kOcclusionTaps, 1)), 0.0, 1.0);

    // The penumbra is as wide as the lamp's disc appears at the height of the tissue that hides it.
    float penumbra = clamp(frame.lamp.x * hiding.x / hiding.y, kNarrowest, kWidest);
    // The lookup is moved away from the surface, by a distance that depends on the slope towards the lamp. So the
    // surface does not shadow itself.
    float slope = clamp(1.0 - dot(n, frame.key.xyz), 0.0, 1.0);
    vec3 off = p + n * (1.5 * frame.light_size.z + 0.26e-3 * slope);
    vec3 q = (frame.light_from_world * vec4(off, 1.0)).xyz;
    // The outer lookups come first; where they agree, the others are left out.
    const int kRing = 6;
    bool all = kShadowTaps <= 2 * kRing;
    float lit = 0.0;
    for (int i = 0; i < (all ? kShadowTaps : kRing); ++i) lit += shadow_lookup(q, tilt, penumbra, kShadowTaps - 1 - i);
    if (all) {
      result.x = lit / float(max(kShadowTaps, 1));
    } else if (lit == 0.0 || lit == float(kRing)) {
      result.x = lit / float(kRing);
    } else {
      for (int i = kRing; i < kShadowTaps; ++i) lit += shadow_lookup(q, tilt, penumbra, kShadowTaps - 1 - i);
      result.x = lit / float(kShadowTaps);
    }
    // The shadow fades out towards the map's border, so that the border is not visible.
    vec2 from_middle = abs(q.xy - 0.5);
    result = mix(vec2(beyond, 1.0), result, smoothstep(0.5, 0.40, max(from_middle.x, from_middle.y)));
  }
  return result;
}

/// Returns the width (m) by which light that travels inside tissue widens the edge of a tool's shadow: about half a free
/// path. `known`: in_tissue_grid().
float shadow_scatter(float translucent, float known) {
  return kLightGrid ? kShadowScatter * translucent * translucent * known : 0.0;
}

/// Returns x, y: as tissue_visibility(), with the tool and the border of the lamp's spot; z, w: the factors of the tool
/// and the spot alone.
/// `scatter`: see shadow_scatter().
vec4 visibility(vec3 p, vec3 n, float beyond, float scatter) {
  vec2 tool = vec2(tool_shadow(p, scatter) * handpiece_shadow(p, scatter) * spot_light(p), tool_occlusion(p, n));
  return vec4(tissue_visibility(p, n, beyond) * tool, tool);
}

float fifth_power(float x) {
  float x2 = x * x;
  return x2 * x2 * x;
}

// The reflected room: dim ceiling and floor, and a window at the side. The lamp's reflection is computed in glossy().
vec3 room(vec3 r, float rough) {
  vec3 color = mix(kRoomFloor, kRoomCeiling, smoothstep(-0.9, 0.9, dot(r, frame.up.xyz)));
  return frame.up.w * (color + smoothstep(0.45 - 0.5 * rough, 1.05, dot(r, frame.window.xyz)) * kRoomWindow);
}

// Returns the mean of room() over the directions above a surface, weighted by the cosine. The window contributes up to
// 0.06 of its radiance less than in the exact integral, because tissue hides the window more than the ceiling.
vec3 ambient_light(vec3 n) {
  float window = max(dot(n, frame.window.xyz) + 0.35, 0.0);
  vec3 walls = mix(kRoomFloor, kRoomCeiling, 0.5 + 0.40 * dot(n, frame.up.xyz));
  return frame.up.w * (walls + 0.22 * window * window * kRoomWindow);
}

struct Look {
  vec3 albedo;
  float rough, translucent;
  float dry;  // reflectance of the dry surface at normal incidence; 1: metal
  float wet;
};
// reflectance at normal incidence of a dry surface with a refractive index of 1.5
const float kUsualDry = 0.04;

/// Returns 1 for metal and 0 for tissue. `dry`: see Look.
float metal_of(float dry) { return step(0.5, dry); }

/// Translucent enamel at grazing angles is bluish, because light of long wavelengths leaves the enamel at other points.
/// `nv`: cosine of the angle between the normal and the direction to the viewer.
vec3 tinted(vec3 albedo, float translucent, float nv) {
  if (kLightGrid) return albedo;
  float rim = (1.0 - nv) * (1.0 - nv) * (1.0 - nv);
  return albedo * mix(vec3(1.0), vec3(0.80, 0.86, 0.92), translucent * rim);
}

/// Returns the light that arrives at tissue of this colour and is reflected diffusely, without the colour's own factor.
/// `light`: visibility(). With a grid of light: `around`: grid_light(); `inside`: light_in_tissue(); `known`:
/// in_tissue_grid().
vec3 arriving(vec3 n, vec3 v, vec3 albedo, float translucent, vec4 light, vec3 around, vec4 inside, float known) {
  float nl = dot(n, frame.key.xyz), open = light.y, key = light.x;
  vec3 lamp = frame.key.w * 0.3183 * kLampColor;
  if (kLightGrid) {
    vec3 local = clamp(nl, 0.0, 1.0) * key * lamp + around;
    return mix(local, inside.rgb * (1.0 - inside.w * (1.0 - light.z)) * light.w, known);
  }
  // Light scatters in translucent tissue. So it also reaches parts of the surface that are turned away from the lamp,
  // and the edges of shadows are soft.
  float wrap = kWrap * translucent;
  float front = clamp((nl + wrap) / (1.0 + wrap), 0.0, 1.0);
  vec3 arrives = mix(vec3(key), vec3(key, key * key * 0.25 + 0.75 * key, key), translucent * (1.0 - key));
  arrives = mix(arrives, sqrt(arrives), kSoftShadow * translucent);
  // Light that is reflected between the walls of a cavity takes the colour of the walls (Jimenez 2016, fitted
  // multibounce).
  vec3 a = 2.0404 * albedo - 0.3324, b = -4.7951 * albedo + 0.6417, c = 2.7552 * albedo + 0.6903;
  vec3 opened = max(vec3(open), ((open * a + b) * open + c) * open);
  // Light in a narrow gap was reflected by gum and teeth, which absorb blue light. The factor was fitted to the
  // pictures of tests/reference.
  opened *= mix(vec3(0.75, 0.62, 0.50), vec3(1.0), open);
  // Where nearby tissue hides the room, this tissue reflects the lamp's light to the point, in its own colour.
  vec3 bounce = kBounce * (1.0 - open) * albedo * lamp;
  return front * arrives * lamp + bounce + ambient_light(n) * opened;
}

/// Returns the reflectance of tissue at normal incidence. Under a film of saliva, less light is reflected.
float film_reflectance(Look look) { return mix(look.dry, kFilmedLeast + kFilmedSlope * look.dry, look.wet); }
vec3 reflectance(Look look) { return metal_of(look.dry) > 0.0 ? look.albedo : vec3(film_reflectance(look)); }

/// Returns the fraction of unpolarised light that a dielectric reflects (Fresnel). `f0`: this fraction at normal
/// incidence; `cosine`: cosine of the angle of incidence.
float dielectric(float f0, float cosine) {
  float index = (1.0 + sqrt(f0)) / (1.0 - sqrt(f0));
  float g = sqrt(index * index - 1.0 + cosine * cosine);
  float across = (g - cosine) / (g + cosine), along = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
  return 0.5 * across * across * (1.0 + along * along);
}

/// Returns the fraction of the room that is visible in the direction r of a reflection. Tissue hides the room near the
/// point and in the directions away from the lamp.
float room_seen(vec3 r, float open) {
  return clamp(open * open + 0.15, 0.0, 1.0) * mix(0.2, 1.0, smoothstep(-0.6, 0.4, dot(r, frame.key.xyz)));
}

/// Light that a surface receives from the room and from other surfaces.
struct Around {
  vec3 diffuse;   // irradiance of the surface, divided by π
  vec3 mirrored;  // radiance from the direction of the reflection
  vec4 inside;    // light_in_tissue()
  float known;    // in_tissue_grid()
};

/// Returns the fraction of the surrounding light that a surface reflects towards a viewer (Fresnel; Schlick's
/// approximation for metal and without a grid of light). `f0`: fraction at normal incidence; `nv`: cosine between
/// normal and viewer.
vec3 grazing(Look look, vec3 f0, float rough, float nv) {
  if (kLightGrid && metal_of(look.dry) == 0.0) return vec3(dielectric(f0.x, nv));
  // A rough surface reflects less: it hides the room itself.
  vec3 most = f0 + 0.7 * (max(vec3(1.0 - rough), f0) - f0);
  return f0 + (most - f0) * fifth_power(1.0 - nv);
}

/// Returns the light that a surface reflects from the direction r. A rough surface reflects light from nearly all
/// directions in front of it.
vec3 reflected(vec3 r, float rough, float open, Around around) {
  if (!kLightGrid) return room(r, rough) * room_seen(r, open);
  return mix(kNearMirrored, 1.0, open) * mix(around.mirrored, around.diffuse, smoothstep(kMirrors, kSpreads, rough));
}

/// Returns the fraction of the tissue's light that passes the film over the tissue. Without a grid of light, the
/// tissues' colours include this loss.
float film_passes(float nv, Look look) {
  return kLightGrid ? 1.0 - dielectric(min(film_reflectance(look), 0.5), nv) : 1.0;
}

/// Returns the density (1/sr) of the half-way directions in which a surface mirrors the lamp: GGX, averaged over the
/// lamp's disc. `nh`, `lh`: cosine of the half-way direction to normal and lamp; `alpha2`: squared width.
float lamp_image(float nh, float lh, float alpha2) {
  float z = max(nh, 0.05), slope = sqrt(max(1.0 - z * z, 0.0)) / z;
  float radius2 = 0.25 * kLampHalfAngle * kLampHalfAngle / max(lh, 0.1), radius = sqrt(radius2);
  float high = slope + radius, low = slope - radius, beyond = max(low, 0.0);
  // In the plane of slopes (tangents of the angle to the normal), the average over a line across the disc is exact.
  // The width of the disc beside the line is approximated.
  float line = high * inversesqrt(high * high + alpha2) - low * inversesqrt(low * low + alpha2);
  float across = inversesqrt(radius2 + alpha2 + beyond * beyond), z2 = z * z;
  return line * across / (2.0 * kPi * radius * z2 * z2);
}

/// Returns the light that is reflected by the wet film over tissue, or by metal.
vec3 glossy(vec3 n, vec3 v, Look look, vec2 light, Around around) {
  vec3 l = frame.key.xyz;
  float nl = dot(n, l), nv = max(dot(n, v), 1e-3), open = light.y, key = light.x;
  float rough = mix(look.rough, min(look.rough, 0.16), look.wet);
  float alpha = max(rough * rough, 0.02);
  vec3 f0 = reflectance(look);
  vec3 h = normalize(l + v);
  float lh = max(dot(l, h), 0.0);
  float nlc = max(nl, 0.0);
  float k = 0.5 * alpha;
  float vis = 0.25 / ((nlc * (1.0 - k) + k) * (nv * (1.0 - k) + k));
  vec3 f = f0 + (1.0 - f0) * fifth_power(1.0 - lh);
  vec3 color = f * lamp_image(dot(n, h), lh, alpha * alpha) * vis * nlc * key * frame.key.w;
  vec3 fr = grazing(look, f0, rough, nv);
  vec3 r = reflect(-v, n);
  return color + fr * reflected(r, rough, open, around);
}

/// Gloss that is computed per vertex: its wide part, and parameters for the lamp's mirror image, which is computed per
/// pixel.
struct CornerGloss {
  vec3 broad;  // wide part: reflection of the room
  vec3 lamp;     // the lamp's mirror image: must be multiplied by lamp_image() for each pixel
  float width;  // squared width (alpha²) of the surface's distribution
};
CornerGloss corner_gloss(vec3 n, vec3 v, vec3 half_way, Look look, vec2 light, Around around) {
  float nl = max(dot(n, frame.key.xyz), 0.0), nv = max(dot(n, v), 1e-3);
  float rough = mix(look.rough, min(look.rough, 0.16), look.wet);
  float alpha = max(rough * rough, 0.02);
  vec3 f0 = reflectance(look);
  float k = 0.5 * alpha;
  vec3 f = f0 + (1.0 - f0) * fifth_power(1.0 - max(dot(frame.key.xyz, half_way), 0.0));
  vec3 fr = grazing(look, f0, rough, nv);
  vec3 r = reflect(-v, n);
  CornerGloss out_gloss;
  out_gloss.broad = fr * reflected(r, rough, light.y, around);
  out_gloss.lamp = f * (0.25 / ((nl * (1.0 - k) + k) * (nv * (1.0 - k) + k))) * nl * light.x * frame.key.w;
  out_gloss.width = alpha * alpha;
  return out_gloss;
}

/// Returns the light that a surface reflects towards the viewer. `gloss_normal`: normal of the wet film, which has
/// ripples of its own.
vec3 shade(vec3 n, vec3 gloss_normal, vec3 v, Look look, vec4 light, Around around) {
  vec3 albedo = tinted(look.albedo * (1.0 - metal_of(look.dry)), look.translucent, max(dot(n, v), 1e-3));
  float passes = film_passes(max(dot(gloss_normal, v), 1e-3), look);
  return passes * albedo * arriving(n, v, albedo, look.translucent, light, around.diffuse, around.inside, around.known) +
         glossy(gloss_normal, v, look, light.xy, around);
}

/// Converts an sRGB colour to linear light.
vec3 linear_light(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

// Tone mapping: keeps the measured colours of tissues and compresses only the highlights, as Khronos PBR Neutral (2024)
// does. Its subtraction of the mirrored light is left out: a deep cavity mirrors nothing, and would become olive.
vec3 tone_map(vec3 color) {
  const float start = 0.8, desaturation = 0.15;
  float peak = max(color.r, max(color.g, color.b));
  if (peak < start) return color;
  float d = 1.0 - start;
  float new_peak = 1.0 - d * d / (peak + d - start);
  color *= new_peak / peak;
  float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
  return mix(color, vec3(new_peak), g);
}
