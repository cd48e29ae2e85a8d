// Scans of one mouth as one tissue. W: first scan, K: another, B: bite. Not on the servo thread. Throws Error.
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
  std::optional<std::filesystem::path> bite;  // teeth of all scans, jaws closed
  // m, moves the opposite jaw away for an instrument
  double open = 0;
};

/// Registration of the bite scan to one of the scans.
struct BiteFit {
  double median = 0, most_of = 0;  // m between both surfaces
  double predicted_error = 0;      // m, rms by the covariance
  double area = 0;                 // m², area of the bite scan that agrees with the scan
};

struct MouthScan {
  Pose X_WK;
  double moved = 0;            // m, displacement of this scan's middle by the bite registration
  std::optional<BiteFit> fit;  // of the bite to this scan; empty: no bite
};

struct ImportedMouth {
  haptics::Imported imported;
  std::vector<MouthScan> scans;
  // W, from the first scan's border to its teeth; zero: unknown
  dvec3 up{0};
  dvec3 top{0};  // m, W, along `up`
};

/// One volume. Without a bite, one frame for all files; with it, frames within about 2 mm, and the bite is registered
/// to each scan. Doubtful ones are refused. Bite and opening need kArch.
ImportedMouth import_mouth(const MouthFiles& files, const haptics::ImportOptions& options);

/// A name with "bite" is the bite. Throws Error for several.
MouthFiles mouth_files(const std::vector<std::filesystem::path>& meshes);

}  // namespace typodont
