// A scan in memory, for looking at it and for importing several regions of it. Constructed once, then used by any
// thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "haptics/import/import.h"

namespace typodont::haptics {

/// Positions are in m, in the file's coordinates: along the scan's own axes, as in ImportReport.
class ScanVolume {
 public:
  /// Reads a scan; not a mesh. Uses options.series, spacing, nan_grey and hounsfield of the options. Throws Error.
  ScanVolume(const std::filesystem::path& file, const ImportOptions& options);
  ~ScanVolume();
  ScanVolume(const ScanVolume&) = delete;
  ScanVolume& operator=(const ScanVolume&) = delete;

  dvec3 lo() const;  // centre of the first voxel
  dvec3 hi() const;  // centre of the last voxel
  dvec3 spacing() const;
  const std::string& format() const;
  const std::string& space() const;  // see ImportReport::space
  const std::vector<std::string>& notes() const;

  /// Grey value at p, trilinear; outside the scan, that of the nearest wall.
  double grey(const dvec3& p) const;
  // Grey values that a picture shows as black and as white: 2 % of the voxels are darker, 0.3 % are brighter.
  double black() const { return black_; }
  double white() const { return white_; }

  /// Imports options.region of the scan, or all of it, as import_tissue() does with the same options. With a coarser
  /// options.voxel it is a quick preview. May run in several threads at once. Throws Error, and what the progress
  /// function throws.
  Imported import(const ImportOptions& options) const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
  double black_ = 0, white_ = 1;
};

}  // namespace typodont::haptics
