// Grids and meshes as bytes, with which the program and the process that has OpenVDB (vdb_process.cpp) exchange them.
// Both come from one build on one machine, so the format needs no byte order and no version. Readers check every count.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "engine/base/pose.h"
#include "haptics/volume/block_grid.h"

namespace typodont::haptics {

/// Content of a volume file, in the file's unit.
struct FlatGrids {
  std::map<std::string, std::variant<DistanceGrid, LabelGrid>> grids;
  double voxel = 0;  // voxel size of the first grid; 0: voxels are not cubes
  dvec3 origin{0};   // position of the first grid's voxel (0,0,0)
  bool exact_outside = true;
  // Data of FilePlace: rows of the rotation, position, axes.
  std::array<dvec3, 3> rotation{dvec3(1, 0, 0), {0, 1, 0}, {0, 0, 1}};
  dvec3 file_origin{0};
  std::string axes;
};
/// Names of the metadata that store the pose of imported tissue in its source file (FilePlace).
inline constexpr std::array<const char*, 3> kFileRotation = {"typodont_file_rotation_x", "typodont_file_rotation_y",
                                                             "typodont_file_rotation_z"};
inline constexpr const char *kFileOrigin = "typodont_file_origin", *kFileAxes = "typodont_file_axes";
// voxels, largest sum of a file's tiles of one grid; OpenVDB's largest tile alone has 7e10
inline constexpr double kMaxTileVoxels = 1e9;

/// The zero set of a field: positions in voxels.
struct FlatMesh {
  std::vector<dvec3> vertices;
  std::vector<glm::uvec3> triangles;
};

/// A write failed, for example because the disk is full.
struct WriteFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Exit status of the process after a WriteFailure.
inline constexpr int kCannotWrite = 3;

/// `file`: descriptor; `name`: used in messages. Throws WriteFailure.
void write_flat(int file, const std::string& name, const FlatGrids& grids);
void write_flat(int file, const std::string& name, const DistanceGrid& distances);
void write_flat(int file, const std::string& name, const FlatMesh& mesh);
/// Throws Error(`name`, …) for content that write_flat() never writes.
FlatGrids read_flat_grids(const std::filesystem::path& file, const std::string& name);
DistanceGrid read_flat_distances(const std::filesystem::path& file, const std::string& name);
FlatMesh read_flat_mesh(const std::filesystem::path& file, const std::string& name);

}  // namespace typodont::haptics
