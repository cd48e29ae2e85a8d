// A scan in memory, from which several regions can be shown and imported.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// A scan in memory. After construction, any thread may use it. Positions are in m in the file's coordinates, along the
/// scan's own axes (as in ImportReport).
class ScanVolume {
 public:
  /// Reads a scan (no mesh). The constructor uses the options series, spacing, nan_grey and hounsfield. Throws Error.
  ScanVolume(const std::filesystem::path& file, const ImportOptions& options);
  ~ScanVolume();
  ScanVolume(const ScanVolume&) = delete;
  ScanVolume& operator=(const ScanVolume&) = delete;

  dvec3 lo() const;  // returns the centre of the first voxel, m
  dvec3 hi() const;  // returns the centre of the last voxel, m
  dvec3 spacing() const;
  const std::string& format() const;
  const std::string& space() const;  // coordinate space of the file: "LPS", "RAS" or empty (unknown)
  const std::vector<std::string>& notes() const;

  /// Returns the grey value at p by trilinear interpolation. Outside the scan, the value at its nearest wall is
  /// returned.
  double grey(const dvec3& p) const;
  // Grey values for pictures: a picture shows black() as black and white() as white. 2 % of the voxels are darker than
  // black(), and 0.3 % are brighter than white().
  double black() const { return black_; }
  double white() const { return white_; }

  /// Imports options.region of the scan, or the whole scan if the options have no region. The result is that of
  /// import_tissue() with the same options. With a larger options.voxel, the import is fast enough for a preview.
  /// Several threads may call this function at the same time. Throws Error, and exceptions of the progress function.
  Imported import(const ImportOptions& options) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
  double black_ = 0, white_ = 1;
};

}  // namespace typodont::haptics
