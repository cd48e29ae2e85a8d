#include "haptics/volume/flat_grids.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <type_traits>
#include <vector>

#include "engine/base/error.h"

namespace typodont::haptics {

namespace {

constexpr std::array<char, 8> kMagic = {'T', 'Y', 'P', 'O', 'F', 'L', 'A', 'T'};
constexpr int kFarthest = 1 << 24;        // voxels, largest coordinate of a block in a file
constexpr std::size_t kLongestName = 64;  // bytes, longest name of a grid

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
  openvdb::Coord place(int multiple) {
    const std::array<int, 3> p{take<int>(), take<int>(), take<int>()};
    for (const int v : p)
      if (v < -kFarthest || v > kFarthest || v % multiple != 0) fail();
    return {p[0], p[1], p[2]};
  }
  bool at_end() const { return left_ == 0; }
  [[noreturn]] void fail() const { throw Error(name_, "", "grids that cannot be", "a tissue volume (.vdb)"); }

 private:
  const std::string& name_;
  std::uint64_t left_;
  std::ifstream in_;
};

void add_place(Writer& out, const openvdb::Coord& at) {
  for (int axis = 0; axis < 3; ++axis) out.add(at[axis]);
}

/// Writes the background value, the tiles whose value differs from it (largest tiles first), and then the blocks of 8³.
template <class Grid>
void write_grid(Writer& out, const Grid& grid) {
  using Tree = typename Grid::TreeType;
  using Value = typename Grid::ValueType;
  const Tree& tree = grid.tree();
  out.add(tree.background());
  for (int level = Tree::DEPTH - 1; level > 0; --level) {
    struct Tile {
      openvdb::Coord at;
      Value value;
      bool on;
    };
    std::vector<Tile> tiles;
    auto it = tree.cbeginValueAll();
    it.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; it; ++it) {
      if (static_cast<int>(it.getLevel()) != level) continue;
      if (it.isValueOn() || *it != tree.background()) tiles.push_back({it.getCoord(), *it, it.isValueOn()});
    }
    out.add(static_cast<std::uint64_t>(tiles.size()));
    for (const Tile& tile : tiles) {
      add_place(out, tile.at);
      out.add(tile.value);
      out.add(static_cast<std::uint8_t>(tile.on));
    }
  }
  out.add(static_cast<std::uint64_t>(tree.leafCount()));
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    add_place(out, leaf->origin());
    out.bytes(&leaf->valueMask(), sizeof leaf->valueMask());
    out.bytes(leaf->buffer().data(), Tree::LeafNodeType::SIZE * sizeof(Value));
  }
}

template <class Grid>
typename Grid::Ptr read_grid(Reader& in) {
  using Tree = typename Grid::TreeType;
  using Leaf = typename Tree::LeafNodeType;
  using Value = typename Grid::ValueType;
  auto grid = Grid::create(in.take<Value>());
  Tree& tree = grid->tree();
  constexpr std::uint64_t kTileBytes = 3 * sizeof(int) + sizeof(Value) + 1;
  for (int level = Tree::DEPTH - 1; level > 0; --level) {
    for (std::uint64_t n = in.count(kTileBytes); n > 0; --n) {
      const openvdb::Coord at = in.place(Leaf::DIM);
      const auto value = in.take<Value>();
      tree.addTile(static_cast<openvdb::Index>(level), at, value, in.take<std::uint8_t>() != 0);
    }
  }
  constexpr std::uint64_t kBlockBytes =
      3 * sizeof(int) + sizeof(typename Leaf::NodeMaskType) + Leaf::SIZE * sizeof(Value);
  for (std::uint64_t n = in.count(kBlockBytes); n > 0; --n) {
    Leaf* leaf = tree.touchLeaf(in.place(Leaf::DIM));
    typename Leaf::NodeMaskType mask;
    in.bytes(&mask, sizeof mask);
    leaf->setValueMask(mask);
    in.bytes(leaf->buffer().data(), Leaf::SIZE * sizeof(Value));
  }
  return grid;
}

}  // namespace

FlatGrids read_vdb(const std::filesystem::path& file, std::span<const std::string> names) {
  openvdb::initialize();
  openvdb::io::File vdb(file.string());
  vdb.setCopyMaxBytes(0);  // reads everything now, so that a truncated file fails here
  vdb.open(false);
  FlatGrids result;
  for (const std::string& name : names) {
    if (!vdb.hasGrid(name)) continue;
    openvdb::GridBase::Ptr grid = vdb.readGrid(name);
    if (result.grids.empty()) {
      const auto& transform = grid->transform();
      if (transform.isLinear() && transform.hasUniformScale()) result.voxel = transform.voxelSize().x();
      result.origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
      if (const auto flag = grid->getMetadata<openvdb::BoolMetadata>("typodont_exact_outside"))
        result.exact_outside = flag->value();
      const auto vector = [&](const char* name, openvdb::Vec3d& value) {
        if (const auto found = grid->getMetadata<openvdb::Vec3DMetadata>(name)) value = found->value();
      };
      for (std::size_t row = 0; row < kFileRotation.size(); ++row) vector(kFileRotation[row], result.rotation[row]);
      vector(kFileOrigin, result.file_origin);
      if (const auto axes = grid->getMetadata<openvdb::StringMetadata>(kFileAxes))
        result.axes = axes->value().substr(0, kLongestName);
    }
    result.grids[name] = std::move(grid);
  }
  return result;
}

void write_flat(int file, const std::string& file_name, const FlatGrids& flat) {
  Writer out(file, file_name);
  out.add(kMagic);
  out.add(flat.voxel);
  for (int axis = 0; axis < 3; ++axis) out.add(flat.origin[axis]);
  out.add(static_cast<std::uint8_t>(flat.exact_outside));
  const auto add_vector = [&](const openvdb::Vec3d& v) {
    for (int axis = 0; axis < 3; ++axis) out.add(v[axis]);
  };
  for (const openvdb::Vec3d& row : flat.rotation) add_vector(row);
  add_vector(flat.file_origin);
  out.add(static_cast<std::uint64_t>(flat.axes.size()));
  out.bytes(flat.axes.data(), flat.axes.size());
  out.add(static_cast<std::uint64_t>(flat.grids.size()));
  for (const auto& [name, grid] : flat.grids) {
    out.add(static_cast<std::uint64_t>(name.size()));
    out.bytes(name.data(), name.size());
    if (const auto floats = openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid)) {
      out.add('f');
      write_grid(out, *floats);
    } else if (const auto integers = openvdb::gridConstPtrCast<openvdb::Int32Grid>(grid)) {
      out.add('i');
      write_grid(out, *integers);
    } else {
      throw Error(file_name, name, grid->valueType(), "float or int32");
    }
  }
  out.end();
}

FlatGrids read_flat(const std::filesystem::path& file, const std::string& name) {
  openvdb::initialize();
  Reader in(file, name);
  if (in.take<std::array<char, 8>>() != kMagic) in.fail();
  FlatGrids flat;
  flat.voxel = in.take<double>();
  for (int axis = 0; axis < 3; ++axis) flat.origin[axis] = in.take<double>();
  flat.exact_outside = in.take<std::uint8_t>() != 0;
  const auto take_vector = [&](openvdb::Vec3d& v) {
    for (int axis = 0; axis < 3; ++axis) v[axis] = in.take<double>();
  };
  for (openvdb::Vec3d& row : flat.rotation) take_vector(row);
  take_vector(flat.file_origin);
  const auto take_name = [&] {
    const std::uint64_t length = in.count(1);
    if (length > kLongestName) in.fail();
    std::string name(length, '\0');
    in.bytes(name.data(), length);
    return name;
  };
  flat.axes = take_name();
  for (std::uint64_t n = in.count(1); n > 0; --n) {
    const std::string grid = take_name();
    switch (in.take<char>()) {
      case 'f':
        flat.grids[grid] = read_grid<openvdb::FloatGrid>(in);
        break;
      case 'i':
        flat.grids[grid] = read_grid<openvdb::Int32Grid>(in);
        break;
      default:
        in.fail();
    }
  }
  if (!in.at_end()) in.fail();
  return flat;
}

}  // namespace typodont::haptics
