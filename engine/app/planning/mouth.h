// Combines the scans of one mouth into one tissue. Frames: W: first scan, K: another scan, B: bite scan. Not for the
// servo thread. Throws Error.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/progress.h"
#include "haptics/import/import.h"

namespace typodont {

struct MouthFiles {
  std::vector<std::filesystem::path> scans;   // the first scan is the one that is drilled
  std::optional<std::filesystem::path> bite;  // scan of all teeth with the jaws closed
  // Distance by which the opposing jaw is moved away to make room for an instrument, m.
  double open = 0;
};

/// Registration of the bite scan to one of the scans.
struct BiteFit {
  double median = 0, most_of = 0;  // m, distance of the bite scan from this scan: median and 95 % quantile
  double predicted_error = 0;      // m, root mean square error predicted by the covariance
  double area = 0;                 // m², area of the bite scan that fits this scan within the tolerance
};

struct MouthScan {
  Pose X_WK;
  double moved = 0;            // m, displacement of this scan's middle by the bite registration
  std::optional<BiteFit> fit;  // bite scan's registration to this scan; empty: none
};

struct ImportedMouth {
  haptics::Imported imported;
  std::vector<MouthScan> scans;
  // Unit vector from the border of the first scan towards its teeth, frame W; zero if unknown.
  dvec3 up{0};
  dvec3 top{0};  // m, frame W, highest point along `up`
};

/// Joins the scans to one volume. Without a bite scan, they must have the same frame; with a bite scan, frames may
/// differ by about 2 mm. Doubtful registrations are refused. A bite scan or an opened mouth needs the preset kArch.
ImportedMouth import_mouth(const MouthFiles& files, const haptics::ImportOptions& options);

/// Sorts mesh files: a file whose name contains "bite" is the bite scan. Throws Error if there are several.
MouthFiles mouth_files(const std::vector<std::filesystem::path>& meshes);

}  // namespace typodont
