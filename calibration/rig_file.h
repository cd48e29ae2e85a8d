// Calibrated fields of a rig: screen, mirror, head, X_WH, and "calibration" (date, serials, covariances, captures).
// Others stay. Throws Error.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "calibration/routine.h"

namespace typodont::calibration {

class RigFile {
 public:
  /// Or a new mirror bench.
  static RigFile load(const std::filesystem::path& file);
  static RigFile create(const std::filesystem::path& file);
  RigFile(RigFile&&) noexcept;
  ~RigFile();

  /// Missing parts have defaults.
  BenchState bench() const;
  /// From the file, or "FILE.captures" beside it.
  std::filesystem::path captures_folder() const;

  /// Such as "2026-03-01T10:15:00Z"; empty: never solved.
  std::string step_date(const std::string& step) const;

  /// Steps without a result keep their record. Throws Error for eyes or a panel that no bench has.
  void set(const BenchState& bench);
  /// For a step without a result.
  void mark_done(const std::string& step);
  void set_device(const std::string& role, const std::string& serial);
  /// With the current date; completely or not at all.
  void save();

 private:
  struct Document;
  explicit RigFile(std::unique_ptr<Document> document);
  std::unique_ptr<Document> document_;
};

/// For --json, and "calibration.steps" of the rig.
std::string bench_json(const BenchState& bench);

}  // namespace typodont::calibration
