#include "engine/app/recording/session_report.h"

#include <algorithm>

#include "engine/app/picture/tissue_view.h"
#include "engine/app/task/task.h"
#include "engine/app/task/tissue_edit.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/surface/mesh_export.h"

namespace typodont {

namespace {

constexpr float kTolerance = 0.3f;  // voxels that the report's triangles may lie off the surface

/// `ideal`: redistanced; empty: every point is where it should be.
session::ResultModel model_of(const haptics::TissueVolume& volume, const DenseCopy* ideal) {
  surface::SurfaceMesher mesher({.tolerance = kTolerance});
  FieldBrick brick;
  for (const glm::ivec3& key : volume.surface_bricks()) {
    volume.read_brick(key, brick);
    mesher.put(brick);
  }
  mesher.remesh();
  const surface::WholeMesh mesh = surface::weld(mesher);
  session::ResultModel model;
  for (const surface::WholeMesh::Vertex& v : mesh.vertices) {
    const dvec3 p_W = volume.frame().to_world(dvec3(v.position));
    const double off = ideal ? ideal->field.sample(ideal->frame.to_voxels(p_W)) * ideal->frame.voxel : 0;
    model.vertices.push_back({glm::vec3(p_W), v.normal, v.tissue, static_cast<float>(off)});
  }
  model.triangles = mesh.triangles;
  return model;
}

}  // namespace

session::ReportOptions report_of(const session::SessionReader& session) {
  session::ReportOptions report;
  try {
    JudgedSession judged = judge_session(session);
    if (judged.ideal) {
      DenseCopy ideal = dense_copy(*judged.ideal);
      ideal.field = session::redistanced(ideal.field);
      report.result = model_of(judged.after, &ideal);
      report.ideal = model_of(*judged.ideal, nullptr);
    } else {
      report.result = model_of(judged.after, nullptr);
    }
    report.preparation = std::move(judged.preparation);
    report.score = std::move(judged.score);
    report.input = std::move(judged.input);
  } catch (const Error& e) {
    log::warn("scored by the volumes in the file alone: {}", e.what());
  }
  return report;
}

session::SessionSummary summary_of(const session::SessionReader& session) {
  try {
    return session::summarize(session, judge_session(session).score);
  } catch (const Error& e) {
    log::warn("{}: scored by the volumes in the file alone: {}", session.file().string(), e.what());
    return session::summarize(session);
  }
}

std::vector<session::SessionSummary> earlier_sessions(const std::filesystem::path& folder,
                                                      const session::SessionReader& session) {
  const session::SessionSummary own = session::summarize(session);
  std::vector<session::SessionSummary> earlier;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(folder, code)) {
    if (entry.path().extension() != ".h5" || std::filesystem::equivalent(entry.path(), session.file(), code)) continue;
    try {
      const session::SessionReader other(entry.path());
      const session::SessionSummary summary = session::summarize(other);
      if (summary.scene != own.scene || summary.trainee != own.trainee) continue;
      if (!own.date.empty() && summary.date >= own.date) continue;
      earlier.push_back(summary_of(other));
    } catch (const Error& e) {
      log::warn("left out: {}", e.what());
    }
  }
  std::sort(earlier.begin(), earlier.end(), [](const auto& a, const auto& b) {
    return std::tie(a.date, a.file) < std::tie(b.date, b.file);
  });
  return earlier;
}

}  // namespace typodont
