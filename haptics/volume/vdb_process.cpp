// typodont-openvdb, the only program that has OpenVDB:
//   read FROM.vdb TO GRID…   copies grids of a volume file; a damaged file ends only this process
//   write FROM TO.vdb        writes grids as a volume file
//   mesh FROM TO             computes the zero set of a grid of distances
// FROM and TO are in the format of flat_grids.h. Messages go to standard output. `read` has limited memory, time and
// files, and cannot reach other processes, the network and other files.
#include <fcntl.h>
#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/guarded_process.h"
#include "engine/base/voxels.h"
#include "haptics/volume/flat_grids.h"

namespace typodont::haptics {
namespace {

openvdb::Coord coord(const glm::ivec3& v) {
  return {v.x, v.y, v.z};
}
glm::ivec3 vec(const openvdb::Coord& c) {
  return {c.x(), c.y(), c.z()};
}
dvec3 vec(const openvdb::Vec3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// Throws Error with `name` for tiles that are larger than any tissue.
template <class Grid>
auto from_vdb(const Grid& grid, const std::string& name) {
  using Value = typename Grid::ValueType;
  using Tree = typename Grid::TreeType;
  const Tree& tree = grid.tree();
  BlockGrid<Value> result(tree.background());
  double voxels = 0;
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (*tile == tree.background() && !tile.isValueOn()) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    voxels += static_cast<double>(box.volume());
    if (voxels > kMaxTileVoxels)
      throw Error(name, "", fmt::format("tissue that is spread over {:.3g} voxels", voxels),
                  fmt::format("at most {:.3g} voxels", kMaxTileVoxels));
    for_each_voxel_between(leaf_key(vec(box.min())), leaf_key(vec(box.max())), [&](int x, int y, int z) {
      result.block({x, y, z}) = typename BlockGrid<Value>::Block(*tile, tile.isValueOn());
    });
  }
  for (auto from = tree.cbeginLeaf(); from; ++from) {
    auto& to = result.block(leaf_key(vec(from->origin()))).touch();
    std::copy_n(from->buffer().data(), to.values.size(), to.values.begin());
    for (std::size_t i = 0; i < to.on.size(); ++i)
      to.on[i] = from->getValueMask().template getWord<std::uint64_t>(static_cast<openvdb::Index>(i));
  }
  return result;
}

template <class Value>
auto to_vdb(const BlockGrid<Value>& grid) {
  using Grid = std::conditional_t<std::is_same_v<Value, float>, openvdb::FloatGrid, openvdb::Int32Grid>;
  auto result = Grid::create(grid.background());
  auto& tree = result->tree();
  grid.for_each_block([&](const glm::ivec3& key, const typename BlockGrid<Value>::Block& block) {
    const openvdb::Coord at = coord(key * BlockGrid<Value>::kSide);
    if (!block.leaf) {
      tree.addTile(1, at, block.tile, block.tile_on);
      return;
    }
    auto* const leaf = tree.touchLeaf(at);
    std::ranges::copy(block.leaf->values, leaf->buffer().data());
    typename Grid::TreeType::LeafNodeType::NodeMaskType mask;
    for (std::size_t i = 0; i < block.leaf->on.size(); ++i)
      mask.template getWord<std::uint64_t>(static_cast<openvdb::Index>(i)) = block.leaf->on[i];
    leaf->setValueMask(mask);
  });
  result->pruneGrid();
  return result;
}

/// Reads the grids in `names` that the file contains. Throws Error, openvdb::Exception, std::bad_alloc.
FlatGrids read_vdb(const std::string& file, std::span<const std::string> names) {
  openvdb::io::File vdb(file);
  vdb.setCopyMaxBytes(0);  // reads everything now, so that a truncated file fails here
  vdb.open(false);
  FlatGrids result;
  for (const std::string& name : names) {
    if (!vdb.hasGrid(name)) continue;
    const openvdb::GridBase::Ptr grid = vdb.readGrid(name);
    if (result.grids.empty()) {
      const auto& transform = grid->transform();
      if (transform.isLinear() && transform.hasUniformScale()) result.voxel = transform.voxelSize().x();
      result.origin = vec(transform.indexToWorld(openvdb::Vec3d(0, 0, 0)));
      if (const auto flag = grid->getMetadata<openvdb::BoolMetadata>("typodont_exact_outside"))
        result.exact_outside = flag->value();
      const auto vector = [&](const char* key, dvec3& value) {
        if (const auto found = grid->getMetadata<openvdb::Vec3DMetadata>(key)) value = vec(found->value());
      };
      for (std::size_t row = 0; row < kFileRotation.size(); ++row) vector(kFileRotation[row], result.rotation[row]);
      vector(kFileOrigin, result.file_origin);
      if (const auto axes = grid->getMetadata<openvdb::StringMetadata>(kFileAxes)) result.axes = axes->value();
    }
    if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) {
      result.grids.emplace(name, from_vdb(*floats, file));
    } else if (const auto integers = openvdb::gridPtrCast<openvdb::Int32Grid>(grid)) {
      result.grids.emplace(name, from_vdb(*integers, file));
    } else {
      throw Error(file, name, grid->valueType(), "float or int32");
    }
  }
  return result;
}

/// Throws the exceptions of OpenVDB.
void write_vdb(const std::string& file, const FlatGrids& flat) {
  openvdb::GridCPtrVec grids;
  for (const auto& [name, values] : flat.grids) {
    const openvdb::GridBase::Ptr grid =
        std::visit([](const auto& typed) -> openvdb::GridBase::Ptr { return to_vdb(typed); }, values);
    grid->setName(name);
    const auto transform = openvdb::math::Transform::createLinearTransform(flat.voxel);
    transform->postTranslate({flat.origin.x, flat.origin.y, flat.origin.z});
    grid->setTransform(transform);
    grids.push_back(grid);
    if (name != "distance") continue;
    std::swap(grids.front(), grids.back());  // other programs show the first grid
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    grid->insertMeta("typodont_version", openvdb::StringMetadata(TYPODONT_VERSION));
    grid->insertMeta("typodont_units", openvdb::StringMetadata("mm"));
    grid->insertMeta("typodont_exact_outside", openvdb::BoolMetadata(flat.exact_outside));
    const auto insert = [&](const char* key, const dvec3& v) {
      grid->insertMeta(key, openvdb::Vec3DMetadata(openvdb::Vec3d(v.x, v.y, v.z)));
    };
    for (std::size_t row = 0; row < kFileRotation.size(); ++row) insert(kFileRotation[row], flat.rotation[row]);
    insert(kFileOrigin, flat.file_origin);
    if (!flat.axes.empty()) grid->insertMeta(kFileAxes, openvdb::StringMetadata(flat.axes));
  }
  openvdb::io::File vdb(file);
  vdb.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
  vdb.write(grids);
  vdb.close();
}

/// Moves a vertex onto the surface by Newton steps along the gradient. OpenVDB uses means of edge crossings, which are
/// not on a curved surface.
template <class Accessor>
openvdb::Vec3d onto_surface(const Accessor& field, openvdb::Vec3d p) {
  using openvdb::tools::BoxSampler;
  const auto value = [&](const openvdb::Vec3d& q) { return static_cast<double>(BoxSampler::sample(field, q)); };
  constexpr int kSteps = 3;             // number of Newton steps per vertex
  constexpr double kMaxStep = 0.25;     // voxels, largest length of a Newton step
  constexpr double kDifference = 0.25;  // voxels, step of the central differences for the gradient
  for (int i = 0; i < kSteps; ++i) {
    openvdb::Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Vec3d off(0.0);
      off[axis] = kDifference;
      gradient[axis] = (value(p + off) - value(p - off)) / (2 * kDifference);
    }
    const double square = gradient.lengthSqr();
    // Near the surface, |gradient|² is about 1. If it is 0.04 or less, the vertex does not move.
    if (!(square > 0.04)) return p;
    openvdb::Vec3d step = -value(p) / square * gradient;
    if (const double length = step.length(); length > kMaxStep) step *= kMaxStep / length;
    p += step;
  }
  return p;
}

/// The zero set: OpenVDB's mesh, with vertices on the zero set of the field.
FlatMesh surface_of(const openvdb::FloatGrid& distance) {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(distance, points, triangles, quads, 0.0, 0.0);
  FlatMesh mesh;
  mesh.vertices.reserve(points.size());
  const auto field = distance.getConstAccessor();
  for (const openvdb::Vec3s& point : points) mesh.vertices.push_back(vec(onto_surface(field, openvdb::Vec3d(point))));
  for (const auto& t : triangles) mesh.triangles.emplace_back(t[0], t[1], t[2]);
  for (const auto& q : quads)
    mesh.triangles.emplace_back(q[0], q[1], q[2]), mesh.triangles.emplace_back(q[0], q[2], q[3]);
  return mesh;
}

int say(const std::string& message, int status = 1) {
  return ::write(STDOUT_FILENO, message.data(), message.size()) < 0 ? kCannotWrite : status;
}

int read(const std::string& from, const std::string& to, std::span<const std::string> names) {
  constexpr std::uint64_t kMemory = 1024ull << 20;  // bytes, memory limit of this process, including libraries
  constexpr std::uint64_t kMemoryPerByte = 200;     // bytes of address space allowed per byte of the file
  constexpr std::uint64_t kMaxMemory = 32ull << 30;
  // largest number of bytes of output per byte of file; tissue needs less
  constexpr std::uint64_t kOutputPerByte = 4096;
  constexpr std::uint64_t kMinOutput = 64ull << 20;
  std::error_code code;
  const std::uint64_t bytes = std::filesystem::file_size(from, code);
  if (code) return 2;
  // The output is opened before the right to write files is given up.
  const int out = open(to.c_str(), O_WRONLY | O_CLOEXEC);
  if (out < 0) return 2;
  const std::uint64_t longest = std::max(kMinOutput, kOutputPerByte * bytes);
  const std::uint64_t memory = std::min(kMaxMemory, kMemory + kMemoryPerByte * bytes);
  limit_process({.memory = memory, .longest_file = longest});
  // Without this signal, writing beyond the limit returns an error and does not end the process.
  std::signal(SIGXFSZ, SIG_IGN);
  give_up_privileges();
  const auto too_large = [&from] {
    return std::string(
        Error(from, "", "sizes beyond what a file of its length may take", "a tissue volume (.vdb)").what());
  };
  try {
    openvdb::initialize();
    write_flat(out, to, read_vdb(from, names));
    return 0;
  } catch (const std::bad_alloc&) {
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    if (limit.rlim_cur >= memory) return say(too_large());
    return say(Error(from, "", fmt::format("a memory limit of {} MB", limit.rlim_cur >> 20),
                     fmt::format("{} MB, which reading this file may take", memory >> 20))
                   .what());
  } catch (const WriteFailure&) {
    // If the output has the largest allowed length, the volume file is wrong. If the output is shorter, the disk is
    // full or the user's limit is smaller.
    const off_t written = lseek(out, 0, SEEK_END);
    if (written < 0 || static_cast<std::uint64_t>(written) < longest) return kCannotWrite;
    return say(too_large());
  } catch (const Error& e) {
    return say(e.what());
  } catch (const std::exception& e) {
    return say(Error(from, "", e.what(), "a tissue volume (.vdb)").what());
  }
}

int write(const std::string& from, const std::string& to) {
  openvdb::initialize();
  write_vdb(to, read_flat_grids(from, from));
  return 0;
}

int mesh(const std::string& from, const std::string& to) {
  openvdb::initialize();
  const int out = open(to.c_str(), O_WRONLY | O_CLOEXEC);
  write_flat(out, to, surface_of(*to_vdb(read_flat_distances(from, from))));
  return 0;
}

int run(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() > 3 && words[0] == "read") return read(words[1], words[2], std::span(words).subspan(3));
    if (words.size() == 3 && words[0] == "write") return write(words[1], words[2]);
    if (words.size() == 3 && words[0] == "mesh") return mesh(words[1], words[2]);
  } catch (const WriteFailure&) {
    return kCannotWrite;
  } catch (const std::exception& e) {
    return say(e.what());
  }
  return 2;
}

}  // namespace
}  // namespace typodont::haptics

/// Ends the process without cleanup, because a sanitizer's cleanup would use forbidden system calls.
int main(int argc, char** argv) {
  _exit(typodont::haptics::run(argc, argv));
}
