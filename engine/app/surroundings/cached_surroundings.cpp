// Caches the surroundings' meshes.
#include "engine/app/surroundings/surroundings.h"
#include "engine/base/cached_result.h"

namespace typodont {

namespace {

constexpr cache::Shelf kMeshes{"surroundings", ".around", 256u << 20};

template <glm::length_t N>
void add(Sha256& key, const glm::vec<N, double>& v) {
  for (glm::length_t i = 0; i < N; ++i) key.add(v[i]);
}

// Each add() below lists all members of a struct, so that a new member of the struct causes a compile error here.

void add(Sha256& key, const ToothForm& form) {
  const auto& [widest, neck, table, height, proximal, buccal, lingual, square, rounding, lean, root, groove_depth,
               groove_width, hills, sides] = form;
  const auto& [skew, distal_narrow, lingual_narrow, distal_lower, corners] = sides;
  add(key, widest), add(key, neck), add(key, table);
  for (const double number : {height, proximal, buccal, lingual, square, rounding, lean, root, groove_depth,
                              groove_width, skew, distal_narrow, lingual_narrow, distal_lower})
    key.add(number);
  add(key, corners);
  key.add(hills.size());
  for (const auto& [at, hill_height, slope, long_by, join] : hills)
    add(key, at), key.add(hill_height), key.add(slope), add(key, long_by), key.add(join);
}

void add(Sha256& key, const ToothRow& row) {
  const auto& [teeth, curve] = row;
  key.add(teeth.size());
  for (const auto& [form, at, R_FR] : teeth) {
    add(key, form), add(key, at);
    for (int i = 0; i < 3; ++i) add(key, R_FR[i]);
  }
  key.add(curve.size());
  for (const glm::dvec2& p : curve) add(key, p);
}

/// Key of the cached meshes. Empty if the volume cannot be read; the code that then makes the meshes reports the error.
std::optional<std::uint64_t> key_of(const SurroundingsPlan& plan) {
  // The meshes do not depend on `monitored` and `soft`.
  const auto& [volume, crown, arch, neighbours, row, mouth, dam, monitored, gum, margin, margin_normal, papilla,
               thickness, length, soft] = plan;
  Sha256 key;
  cache::add_build(key);
  const auto content = cache::hash_of(volume);
  if (!content) return std::nullopt;
  key.add(*content);
  add(key, crown), add(key, arch);
  key.add(neighbours.size());
  for (const auto& [contact, normal, scale] : neighbours) add(key, contact), add(key, normal), add(key, scale);
  key.add(row.has_value());
  if (row) add(key, *row);
  key.add(static_cast<int>(mouth));
  key.add(dam.has_value());
  if (dam) key.add(dam->gap), key.add(dam->clamp);
  key.add(gum);
  add(key, margin), add(key, margin_normal);
  for (const double number : {papilla, thickness, length}) key.add(number);
  return key.key();
}

bool bricks_of(cache::Parts& file, std::vector<render::MeshUpdate>& bricks) {
  return file.list(bricks, [&](auto& brick) {
    return file.value(brick.brick) && file.values(brick.vertices) && file.values(brick.indices) &&
           file.value(brick.two_sided);
  });
}

bool parts_of(cache::Parts& file, Surroundings& around) {
  return file.value(around.covered) && file.value(around.coarse_from) && file.optional(around.lit) &&
         file.list(around.meshes, [&](auto& mesh) {
           return file.value(mesh.id) && file.value(mesh.origin) && bricks_of(file, mesh.bricks) &&
                  bricks_of(file, mesh.coarse);
         });
}

}  // namespace

Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan) {
  Surroundings around;
  if (!plan) return around;
  cache::read_or_make(
      kMeshes, key_of(*plan), [&](cache::Parts& file) { return parts_of(file, around); },
      [&] { around = make_surroundings(*plan); });
  return around;
}

}  // namespace typodont
