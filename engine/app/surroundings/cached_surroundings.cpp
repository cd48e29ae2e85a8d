// Caches the surroundings' meshes.
#include <filesystem>
#include <fstream>
#include <type_traits>

#include "engine/app/surroundings/surroundings.h"
#include "engine/base/cache.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxKept = 256u << 20;  // bytes, largest total size of the cached files
constexpr const char* kSuffix = ".around";

template <glm::length_t N>
void add(Sha256& key, const glm::vec<N, double>& v) {
  for (glm::length_t i = 0; i < N; ++i) key.add(v[i]);
}

// Each add() below lists all members of a struct, so that a new member of the struct causes a compile error here.

void add(Sha256& key, const ToothForm& form) {
  const auto& [widest, neck, table, height, proximal, buccal, lingual, square, rounding, lean, root, groove_depth,
               groove_width, hills] = form;
  add(key, widest), add(key, neck), add(key, table);
  for (const double number :
       {height, proximal, buccal, lingual, square, rounding, lean, root, groove_depth, groove_width})
    key.add(number);
  key.add(hills.size());
  for (const auto& [at, hill_height, slope, long_by] : hills)
    add(key, at), key.add(hill_height), key.add(slope), add(key, long_by);
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
  for (const auto& [contact, scale, turn] : neighbours) add(key, contact), add(key, scale), key.add(turn);
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

/// Calls `part` for each number and each array of the bricks, in the order of the cached file.
template <class Bricks, class Part>
bool each_brick(Bricks& bricks, Part&& part) {
  return part.list(bricks, [&](auto& brick) {
    return part.value(brick.brick) && part.values(brick.vertices) && part.values(brick.indices) &&
           part.value(brick.two_sided);
  });
}
template <class Around, class Part>
bool each_part(Around& around, Part&& part) {
  return part.value(around.covered) && part.value(around.coarse_from) && part.optional(around.lit) &&
         part.list(around.meshes, [&](auto& mesh) {
           return part.value(mesh.id) && part.value(mesh.origin) && each_brick(mesh.bricks, part) &&
                  each_brick(mesh.coarse, part);
         });
}

struct Writer {
  std::ofstream out;
  bool bytes(const void* data, std::size_t size) {
    return static_cast<bool>(out.write(static_cast<const char*>(data), static_cast<std::streamsize>(size)));
  }
  template <class T>
  bool value(const T& number) {
    static_assert(std::is_trivially_copyable_v<T>);
    return bytes(&number, sizeof number);
  }
  template <class T>
  bool values(const std::vector<T>& all) {
    static_assert(std::is_trivially_copyable_v<T>);
    return value(all.size()) && bytes(all.data(), all.size() * sizeof(T));
  }
  template <class T>
  bool optional(const std::optional<T>& maybe) {
    return value(maybe.has_value()) && (!maybe || value(*maybe));
  }
  template <class T, class Each>
  bool list(const std::vector<T>& all, Each&& each) {
    if (!value(all.size())) return false;
    for (const T& one : all)
      if (!each(one)) return false;
    return true;
  }
};

struct Reader {
  std::ifstream in;
  std::uintmax_t size;  // bytes, size of the file; a list that states more elements than this is invalid
  bool bytes(void* data, std::size_t count) {
    return static_cast<bool>(in.read(static_cast<char*>(data), static_cast<std::streamsize>(count)));
  }
  template <class T>
  bool value(T& number) {
    return bytes(&number, sizeof number);
  }
  template <class T>
  bool resize(std::vector<T>& all) {
    std::size_t count = 0;
    if (!value(count) || count > size) return false;
    all.resize(count);
    return true;
  }
  template <class T>
  bool values(std::vector<T>& all) {
    return resize(all) && bytes(all.data(), all.size() * sizeof(T));
  }
  template <class T>
  bool optional(std::optional<T>& maybe) {
    bool there = false;
    return value(there) && (!there || value(maybe.emplace()));
  }
  template <class T, class Each>
  bool list(std::vector<T>& all, Each&& each) {
    if (!resize(all)) return false;
    for (T& one : all)
      if (!each(one)) return false;
    return true;
  }
};

}  // namespace

Surroundings make_surroundings(const std::optional<SurroundingsPlan>& plan) {
  if (!plan) return {};
  const fs::path in = cache::folder("surroundings");
  const auto key = in.empty() ? std::nullopt : key_of(*plan);
  if (key) {
    Surroundings kept;
    if (const fs::path file = cache::find(in, *key, kSuffix); !file.empty()) {
      std::error_code code;
      if (each_part(kept, Reader{std::ifstream(file, std::ios::binary), fs::file_size(file, code)})) return kept;
    }
  }
  Surroundings made = make_surroundings(*plan);
  if (key)
    cache::keep(in, *key, kSuffix, kMaxKept, [&](const fs::path& file) {
      Writer writer{std::ofstream(file, std::ios::binary)};
      if (!each_part(made, writer) || !writer.out.flush())
        throw Error(file.string(), "", "not written", "a writable place");
    });
  return made;
}

}  // namespace typodont
