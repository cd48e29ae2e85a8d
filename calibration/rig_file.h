// The rig file's calibrated fields. Reads and writes what the calibration owns (screen, mirror, head, X_WH, and one
// block "calibration" with date, device serials, covariances and where the raw captures lie) and leaves every other
// field as it is. Throws Error naming file and key.
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
  /// A file that exists, or a new mirror rig.
  static RigFile load(const std::filesystem::path& file);
  static RigFile create(const std::filesystem::path& file);
  RigFile(RigFile&&) noexcept;
  ~RigFile();

  /// The geometry and the arm as the file has them; missing parts keep their defaults.
  BenchState bench() const;
  /// "FILE.captures" beside the rig, or what the file names.
  std::filesystem::path captures_folder() const;

  /// When a step was last solved ("2026-03-01T10:15:00Z"); empty: never.
  std::string step_date(const std::string& step) const;

  /// Takes over what the bench's steps found. Steps without a result keep their record.
  void set(const BenchState& bench);
  /// A step without a result of its own was done now.
  void mark_done(const std::string& step);
  void set_device(const std::string& role, const std::string& serial);
  /// Adds the date and writes the file whole.
  void save();

 private:
  struct Document;
  explicit RigFile(std::unique_ptr<Document> document);
  std::unique_ptr<Document> document_;
};

/// What every step found, as JSON: what --json prints and the rig's "calibration.steps" holds.
std::string bench_json(const BenchState& bench);

}  // namespace typodont::calibration
