#include "engine/app/review/session_report.h"

#include <algorithm>
#include <future>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/recording/replay.h"
#include "engine/app/task/find_defects.h"
#include "engine/app/task/task.h"
#include "engine/app/tissue/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/log.h"
#include "engine/base/progress.h"
#include "engine/surface/mesh_export.h"

namespace typodont {

namespace {

constexpr float kTolerance = 0.3f;  // voxels, largest distance of the report's triangles from the surface

// Largest number of label samples along each side of the volume. The labels add some hundred kilobytes to a page.
constexpr int kMaxLabels = 200;

/// Copies the label of every n-th voxel, so that there are at most kMaxLabels samples per side.
session::TissueLabels labels_of(const haptics::TissueVolume& volume) {
  const DenseCopy all = dense_copy(volume);
  const int longest = std::max({all.field.size.x, all.field.size.y, all.field.size.z});
  const int every = (longest + kMaxLabels - 1) / kMaxLabels;
  session::TissueLabels labels;
  labels.frame = {all.frame.origin, every * all.frame.voxel};
  labels.size = (all.field.size - 1) / every + 1;
  for (int x = 0; x < all.field.size.x; x += every)
    for (int y = 0; y < all.field.size.y; y += every)
      for (int z = 0; z < all.field.size.z; z += every) labels.tissue.push_back(all.tissue[all.field.at(x, y, z)]);
  return labels;
}

/// A tissue mesh with more triangles than this is not copied into the report. The surface of the distance field is
/// shown instead. A page with so many triangles has some ten megabytes.
constexpr std::size_t kMaxOwnTriangles = 200'000;

/// Makes the 3D model of the report. `own`: true uses the triangles of volume.mesh(), false the surface of the distance
/// field. `ideal`: target shape from which differences are computed; null: no differences.
session::ResultModel model_of(const haptics::TissueVolume& volume, bool own, const haptics::TissueVolume* ideal) {
  const bool shown = own && volume.mesh() && volume.mesh()->triangles.size() <= kMaxOwnTriangles;
  const surface::WholeMesh mesh = whole_surface(volume, shown, kTolerance);
  std::optional<session::TrueDistances> distances;
  VoxelFrame frame;  // grid of the distance field
  if (ideal) {
    DenseCopy copy = dense_copy(*ideal);
    frame = copy.frame;
    distances.emplace(std::move(copy.field));
  }
  session::ResultModel model;
  for (const surface::WholeMesh::Vertex& v : mesh.vertices) {
    const dvec3 p_W = volume.frame().to_world(dvec3(v.position));
    const double off = distances ? distances->sample(frame.to_voxels(p_W)) * frame.voxel : 0;
    model.vertices.push_back({glm::vec3(p_W), v.normal, v.tissue, static_cast<float>(off)});
  }
  model.triangles = mesh.triangles;
  model.labels = labels_of(volume);
  return model;
}

void show(const Scene& scene, const haptics::TissueVolume& after, const haptics::TissueVolume* ideal,
          session::ReportOptions& report) {
  auto wanted = std::async(std::launch::async, [&] {
    if (ideal) report.ideal = model_of(*ideal, false, nullptr);
  });
  report.result = model_of(after, draws_own_surface(scene), ideal);
  wanted.get();
}

}  // namespace

session::ReportOptions result_of(const Scene& scene, const haptics::TissueVolume& after) {
  session::ReportOptions report;
  const auto ideal = ideal_tissue(scene, load_untouched(scene));
  show(scene, after, ideal ? &*ideal : nullptr, report);
  return report;
}

session::Verification verify(const session::SessionReader& session) {
  using State = session::Verification::State;
  const ReplayResult replay = replay_session(session);
  session::Verification verification{replay.identical ? State::kIdentical : State::kDiffers, replay.what_differs};
  if (const auto& rerun = replay.with_todays_law) {
    verification.state = State::kOtherLaw;
    verification.force_rms = rerun->force_off_rms, verification.force_max = rerun->force_off_max;
    verification.removed = rerun->removed, verification.removed_before = rerun->removed_before;
  }
  return verification;
}

session::ReportOptions report_of(const session::SessionReader& session) {
  session::ReportOptions report;
  try {
    EvaluatedSession judged = evaluate_session(session);
    // An open mesh encloses no volume. Its distance field comes from a mesh that was closed with a cap or thickened to
    // a shell, so its volume means nothing.
    report.encloses_nothing = judged.start.mesh() && !judged.start.exact_outside();
    show(judged.scene, judged.after, judged.ideal ? &*judged.ideal : nullptr, report);
    report.defects = find_defects(session, judged);
    report.preparation = std::move(judged.preparation);
    report.score = std::move(judged.score);
    report.input = std::move(judged.input);
    if (has_other_law(session)) report.verification = verify(session);
  } catch (const Error& e) {
    report.not_measured = e.what();
    log::warn("{}: the tissue is not measured: {}", session.file().string(), e.what());
  }
  return report;
}

session::SessionSummary summary_of(const session::SessionReader& session) {
  try {
    return session::summarize(session, evaluate_session(session).score);
  } catch (const Error& e) {
    log::warn("{}: the tissue is not measured: {}", session.file().string(), e.what());
    return session::summarize(session);
  }
}

session::SessionSummary summary_of(const session::SessionReader& session, const Scene& scene) {
  return session::summarize(session, evaluate_session(session, scene).score);
}

namespace {

/// Names a session relative to the folder, so that equal file names in its subfolders differ.
session::SessionSummary named_in(const std::filesystem::path& folder, const std::filesystem::path& file,
                                 session::SessionSummary summary) {
  summary.file = file.lexically_relative(folder).string();
  return summary;
}

/// Reads the sessions below the folder for which `wanted` is true, except the current session. Skips files that are not
/// sessions.
template <typename Wanted>
std::vector<session::SessionSummary> others_in(const std::filesystem::path& folder,
                                               const session::SessionReader& session, const Wanted& wanted) {
  std::vector<session::SessionSummary> others;
  std::error_code code;
  for (const std::filesystem::path& file : files_below(folder, ".h5")) {
    if (std::filesystem::equivalent(file, session.file(), code)) continue;
    try {
      const session::SessionReader other(file);
      session::SessionSummary summary = named_in(folder, file, session::summarize(other));
      if (wanted(summary)) others.push_back(std::move(summary));
    } catch (const Error& e) {
      log::warn("left out: {}", e.what());
    }
  }
  std::sort(others.begin(), others.end(),
            [](const auto& a, const auto& b) { return std::tie(a.date, a.file) < std::tie(b.date, b.file); });
  return others;
}

}  // namespace

std::vector<session::SessionSummary> sessions_in(const std::filesystem::path& folder, Progress& progress) {
  const std::vector<std::filesystem::path> files = files_below(folder, ".h5");
  std::vector<session::SessionSummary> sessions;
  for (std::size_t i = 0; i < files.size(); ++i) {
    progress.at(static_cast<double>(i) / static_cast<double>(files.size()));
    try {
      sessions.push_back(named_in(folder, files[i], summary_of(session::SessionReader(files[i]))));
    } catch (const Error& e) {
      log::warn("left out: {}", e.what());
    }
  }
  if (!sessions.empty()) return sessions;
  throw Error(folder.string(), "", files.empty() ? "a folder without sessions" : "no session that can be read",
              "sessions (.h5)");
}

std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session) {
  const session::SessionSummary own = session::summarize(session);
  auto earlier = others_in(folder, session, [&](const session::SessionSummary& other) {
    return other.scene == own.scene && other.trainee == own.trainee && (own.date.empty() || other.date < own.date);
  });
  for (session::SessionSummary& one : earlier) one = summary_of(session::SessionReader(folder / one.file));
  return earlier;
}

std::optional<session::SessionSummary> expert_session(const std::filesystem::path& folder,
                                                      const session::SessionReader& session) {
  const session::SessionSummary own = session::summarize(session);
  const auto same =
      others_in(folder, session, [&](const session::SessionSummary& other) { return other.scene == own.scene; });
  if (same.empty()) return std::nullopt;
  return summary_of(session::SessionReader(folder / same.back().file));
}

}  // namespace typodont
