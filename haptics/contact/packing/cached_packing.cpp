#include "haptics/contact/packing/cached_packing.h"

#include "engine/base/cached_result.h"

namespace typodont::haptics::packing {

namespace {

constexpr cache::Shelf kPackings{"packing", ".packing", 256u << 20, kNanosPerSecond / 2};

bool parts_of(cache::Parts& file, SpherePacking& p) {
  return file.value(p.seed) && file.value(p.tissue_hash) && file.value(p.max_radius) && file.value(p.max_hole) &&
         file.value(p.solid_volume) && file.values(p.center) && file.values(p.radius) && file.values(p.tissue);
}

}  // namespace

SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options) {
  Sha256 key;
  cache::add_build(key);
  key.add(tissue.hash());
  key.add(static_cast<std::uint64_t>(options.spheres));
  key.add(options.seed);
  key.add(options.max_radius);
  SpherePacking packing;
  cache::read_or_make(
      kPackings, key.key(), [&](cache::Parts& file) { return parts_of(file, packing); },
      [&] { packing = pack_spheres(tissue, options); });
  return packing;
}

}  // namespace typodont::haptics::packing
