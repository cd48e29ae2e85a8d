#include "haptics/volume/flat_grids.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <type_traits>
#include <vector>

#include "engine/base/error.h"

namespace typodont::haptics {

namespace {

constexpr std::array<char, 8> kMagic = {'T', 'Y', 'P', 'O', 'F', 'L', 'A', 'T'};
constexpr int kFarthest = 1 << 21;        // blocks, largest coordinate of a block in a file
constexpr std::size_t kLongestName = 64;  // bytes, longest name of a grid
constexpr std::size_t kMostNodes = 8192;  // half a gigabyte; tissue of 10⁹ voxels has about 1000

class Writer {
 public:
  Writer(int file, const std::string& name) : file_(file), name_(name) {}
  template <class T>
  void add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof value);
  }
  void bytes(const void* from, std::size_t size) {
    constexpr std::size_t kEnough = 1 << 20;
    const auto* first = static_cast<const char*>(from);
    buffer_.insert(buffer_.end(), first, first + size);
    if (buffer_.size() >= kEnough) end();
  }
  void end() {
    for (std::size_t done = 0; done < buffer_.size();) {
      const ssize_t n = ::write(file_, buffer_.data() + done, buffer_.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) throw WriteFailure(name_ + ": " + std::strerror(errno));
      done += static_cast<std::size_t>(n);
    }
    buffer_.clear();
  }
  template <class T>
  void list(const std::vector<T>& all) {
    add(static_cast<std::uint64_t>(all.size()));
    bytes(all.data(), all.size() * sizeof(T));
  }

 private:
  int file_;
  const std::string& name_;
  std::vector<char> buffer_;
};

class Reader {
 public:
  Reader(const std::filesystem::path& file, const std::string& name)
      : name_(name), left_(std::filesystem::file_size(file)), in_(file, std::ios::binary) {}
  void bytes(void* to, std::uint64_t size) {
    if (size > left_) fail();
    in_.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
    if (!in_) fail();
    left_ -= size;
  }
  template <class T>
  T take() {
    T value;
    bytes(&value, sizeof value);
    return value;
  }
  /// Reads a count. Fails if the rest of the file is too short for that many elements of `size` bytes.
  std::uint64_t count(std::uint64_t size) {
    const auto n = take<std::uint64_t>();
    if (n > left_ / size) fail();
    return n;
  }
  /// Reads the key of a block.
  glm::ivec3 key() {
    const auto key = take<glm::ivec3>();
    for (int axis = 0; axis < 3; ++axis)
      if (key[axis] < -kFarthest || key[axis] > kFarthest) fail();
    return key;
  }
  /// Reads a list that Writer::list() has written.
  template <class T>
  std::vector<T> list() {
    std::vector<T> all(count(sizeof(T)));
    bytes(all.data(), all.size() * sizeof(T));
    return all;
  }
  bool at_end() const { return left_ == 0; }
  [[noreturn]] void fail() const { throw Error(name_, "", "grids that cannot be", "a tissue volume (.vdb)"); }

 private:
  const std::string& name_;
  std::uint64_t left_;
  std::ifstream in_;
};

/// Equal tiles that follow each other along z.
template <class Value>
struct TileRun {
  glm::ivec3 first;  // key
  std::int32_t count;
  Value value;
  std::int32_t on;
};

/// Writes the background value, the tiles that differ from it, and then the leaves.
template <class Value>
void write_grid(Writer& out, const BlockGrid<Value>& grid) {
  using Grid = BlockGrid<Value>;
  std::vector<TileRun<Value>> runs;
  grid.for_each_block([&](const glm::ivec3& key, const typename Grid::Block& block) {
    if (block.leaf) return;
    if (!runs.empty()) {
      TileRun<Value>& last = runs.back();
      if (last.first + glm::ivec3(0, 0, last.count) == key && last.value == block.tile && last.on == block.tile_on) {
        ++last.count;
        return;
      }
    }
    runs.push_back({key, 1, block.tile, block.tile_on});
  });
  out.add(grid.background());
  out.list(runs);
  out.add(static_cast<std::uint64_t>(grid.leaf_count()));
  grid.for_each_block([&](const glm::ivec3& key, const typename Grid::Block& block) {
    if (!block.leaf) return;
    out.add(key);
    out.add(block.leaf->on);
    out.add(block.leaf->values);
  });
}

template <class Value>
BlockGrid<Value> read_grid(Reader& in) {
  using Grid = BlockGrid<Value>;
  Grid grid(in.take<Value>());
  double voxels = 0;
  for (std::uint64_t n = in.count(sizeof(TileRun<Value>)); n > 0; --n) {
    const glm::ivec3 first = in.key();
    const auto count = in.take<std::int32_t>();
    const auto value = in.take<Value>();
    const bool on = in.take<std::int32_t>() != 0;
    voxels += static_cast<double>(count) * Grid::kSize;
    if (count < 1 || voxels > kMaxTileVoxels || grid.nodes() > kMostNodes) in.fail();
    for (int i = 0; i < count; ++i) grid.block(first + glm::ivec3(0, 0, i)) = typename Grid::Block(value, on);
  }
  using Leaf = typename Grid::Leaf;
  for (std::uint64_t n = in.count(sizeof(glm::ivec3) + sizeof(Leaf::on) + sizeof(Leaf::values)); n > 0; --n) {
    if (grid.nodes() > kMostNodes) in.fail();
    Leaf& leaf = grid.block(in.key()).touch();
    in.bytes(&leaf.on, sizeof leaf.on);
    in.bytes(&leaf.values, sizeof leaf.values);
  }
  return grid;
}

}  // namespace

void write_flat(int file, const std::string& name, const FlatGrids& flat) {
  Writer out(file, name);
  out.add(kMagic);
  out.add(flat.voxel);
  out.add(flat.origin);
  out.add(static_cast<std::uint8_t>(flat.exact_outside));
  out.add(flat.rotation);
  out.add(flat.file_origin);
  const auto add_name = [&](const std::string& text) {
    out.add(static_cast<std::uint64_t>(text.size()));
    out.bytes(text.data(), text.size());
  };
  add_name(flat.axes);
  out.add(static_cast<std::uint64_t>(flat.grids.size()));
  for (const auto& [grid_name, grid] : flat.grids) {
    add_name(grid_name);
    out.add(static_cast<std::uint8_t>(grid.index()));
    std::visit([&](const auto& typed) { write_grid(out, typed); }, grid);
  }
  out.end();
}

FlatGrids read_flat_grids(const std::filesystem::path& file, const std::string& name) {
  Reader in(file, name);
  if (in.take<std::array<char, 8>>() != kMagic) in.fail();
  FlatGrids flat;
  flat.voxel = in.take<double>();
  flat.origin = in.take<dvec3>();
  flat.exact_outside = in.take<std::uint8_t>() != 0;
  flat.rotation = in.take<std::array<dvec3, 3>>();
  flat.file_origin = in.take<dvec3>();
  const auto take_name = [&] {
    const std::uint64_t length = in.count(1);
    if (length > kLongestName) in.fail();
    std::string text(length, '\0');
    in.bytes(text.data(), length);
    return text;
  };
  flat.axes = take_name();
  for (std::uint64_t n = in.count(1); n > 0; --n) {
    const std::string grid = take_name();
    switch (in.take<std::uint8_t>()) {
      case 0:
        flat.grids.emplace(grid, read_grid<float>(in));
        break;
      case 1:
        flat.grids.emplace(grid, read_grid<std::int32_t>(in));
        break;
      default:
        in.fail();
    }
  }
  if (!in.at_end()) in.fail();
  return flat;
}

void write_flat(int file, const std::string& name, const DistanceGrid& distances) {
  Writer out(file, name);
  write_grid(out, distances);
  out.end();
}

DistanceGrid read_flat_distances(const std::filesystem::path& file, const std::string& name) {
  Reader in(file, name);
  DistanceGrid distances = read_grid<float>(in);
  if (!in.at_end()) in.fail();
  return distances;
}

void write_flat(int file, const std::string& name, const FlatMesh& mesh) {
  Writer out(file, name);
  out.list(mesh.vertices);
  out.list(mesh.triangles);
  out.end();
}

FlatMesh read_flat_mesh(const std::filesystem::path& file, const std::string& name) {
  Reader in(file, name);
  FlatMesh mesh;
  mesh.vertices = in.list<dvec3>();
  mesh.triangles = in.list<glm::uvec3>();
  if (!in.at_end()) in.fail();
  return mesh;
}

}  // namespace typodont::haptics
