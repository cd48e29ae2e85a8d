#include "haptics/contact/packing/cached_packing.h"

#include <fstream>

#include "engine/base/cache.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"

namespace typodont::haptics::packing {

namespace {

namespace fs = std::filesystem;

constexpr Nanos kWorthKeeping = kNanosPerSecond / 2;
constexpr std::uintmax_t kMaxKept = 256u << 20;  // bytes, largest total size of the cache
constexpr const char* kSuffix = ".packing";

/// Calls use(address, bytes) for each array of a packing.
template <class Packing, class Use>
bool each_part(Packing& p, Use&& use) {
  const auto part = [&](auto& value) { return use(&value, sizeof value); };
  const auto list = [&](auto& values) { return use(values.data(), values.size() * sizeof values[0]); };
  return part(p.seed) && part(p.tissue_hash) && part(p.max_radius) && part(p.max_hole) && part(p.solid_volume) &&
         list(p.center) && list(p.radius) && list(p.tissue);
}

/// Writes a packing of spheres to a file. Throws Error.
void write(const fs::path& path, const SpherePacking& packing) {
  std::ofstream out(path, std::ios::binary);
  const bool written = each_part(packing, [&](const auto* data, std::size_t bytes) {
    return static_cast<bool>(out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(bytes)));
  });
  if (!written || !out.flush()) throw Error(path.string(), "", "not written", "a writable place");
}

/// Returns false if the file contains no packing of `spheres` spheres.
bool read(const fs::path& path, std::size_t spheres, SpherePacking& packing) {
  std::ifstream in(path, std::ios::binary);
  packing.center.resize(spheres), packing.radius.resize(spheres), packing.tissue.resize(spheres);
  return each_part(packing, [&](auto* data, std::size_t bytes) {
    return static_cast<bool>(in.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(bytes)));
  });
}

}  // namespace

SpherePacking cached_packing(const TissueVolume& tissue, const PackOptions& options) {
  const fs::path in = cache::folder("packing");
  Sha256 key;
  cache::add_build(key);
  key.add(tissue.hash());
  key.add(static_cast<std::uint64_t>(options.spheres));
  key.add(options.seed);
  key.add(options.max_radius);
  SpherePacking kept;
  if (const fs::path file = cache::find(in, key.key(), kSuffix); !file.empty() && read(file, options.spheres, kept)) {
    return kept;
  }
  const Nanos began = now();
  SpherePacking packing = pack_spheres(tissue, options);
  if (now() - began > kWorthKeeping) {
    cache::keep(in, key.key(), kSuffix, kMaxKept, [&](const fs::path& file) { write(file, packing); });
  }
  return packing;
}

}  // namespace typodont::haptics::packing
