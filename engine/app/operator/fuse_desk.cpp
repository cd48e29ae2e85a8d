#include "engine/app/operator/fuse_desk.h"

#include <array>
#include <filesystem>
#include <utility>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {
constexpr int kSurfacePixels = 560;  // pixels, side of a surface's picture

struct DrawnSurfaces {
  std::array<SurfacePicture, 2> views;
  std::vector<render::Picture> pictures;
};
}  // namespace

void FuseDesk::open() {
  // The scan's labels do not change while this page is shown, so earlier changes come first.
  if (!s_.scan.changes.empty()) return s_.scan.change([this](const ScanReview&) { open(); });
  const std::shared_ptr<const ScanReview> review = s_.scan.review;
  if (!review || !review->can_correct()) return s_.fail(s_.text("op.scan_needs_full"));
  close();
  s_.open(Page::kFuse);
  work_.make(
      [review, file = std::filesystem::path(s_.fuse.file.data()),
       unit = static_cast<double>(s_.fuse.unit_mm) * kMillimetre](Progress& progress) {
        progress.stage("op.loading", 0, 1);
        const auto ct = std::make_shared<const haptics::DenseTissue>(review->labels()->tissue);
        return std::make_shared<ScanFusion>(ct, file, unit);
      },
      [this](std::shared_ptr<ScanFusion> loaded) {
        s_.fuse.fusion = std::move(loaded);
        s_.fuse.changed = true;
        s_.say(s_.text("op.fuse_pick"));
        log::info("surfaces ready");
      },
      [this](const std::exception&) {
        s_.page = Page::kScan;
        throw;
      });
}

void FuseDesk::register_points() {
  const std::shared_ptr<ScanFusion> fusion = s_.fuse.fusion;
  if (!fusion || !fusion->can_register()) return;
  work_.make(
      [fusion](Progress& progress) {
        progress.stage("op.fuse_registering", 0, 1);
        return fusion->registered();
      },
      [this](ScanRegistration found) {
        if (!s_.fuse.fusion) return;
        const calibration::SurfaceRegistration fine = found.fine;
        s_.fuse.fusion->show(std::move(found));
        s_.fuse.changed = true;
        s_.say(s_.text("op.fuse_laid"));
        log::info("registered: {:.3f} mm median, ± {:.3f} mm", fine.median / kMillimetre,
                  fine.predicted_error / kMillimetre);
      });
}

void FuseDesk::take() {
  const std::shared_ptr<const ScanFusion> fusion = s_.fuse.fusion;
  if (!fusion || !fusion->registration()) return;
  work_.make(
      [fusion](Progress& progress) {
        progress.stage("op.fuse_replacing", 0, 1);
        return fusion->fused(progress);
      },
      [this](haptics::Fused made) {
        s_.scan.change(
            [tissue = std::move(made.tissue)](ScanReview& review) mutable { review.replace(std::move(tissue)); });
        close();
        s_.page = Page::kScan;
        s_.say(s_.text("op.fuse_done"));
        log::info("crowns replaced: {:.0f} mm²", made.report.covered_area / kSquareMillimetre);
      });
}

bool FuseDesk::look() {
  FuseForm& form = s_.fuse;
  if (s_.page != Page::kFuse || !form.fusion) return false;
  const bool drawn = preview_.look();
  if (!preview_.due(form.changed)) return drawn;
  form.changed = false;
  preview_.begin(
      [views =
           std::array{form.fusion->view(ScanFusion::kScan), form.fusion->view(ScanFusion::kCt)}](Progress& progress) {
        DrawnSurfaces surfaces{views, {}};
        for (SurfacePicture& view : surfaces.views) {
          progress.at(0);
          surfaces.pictures.push_back(view.draw(kSurfacePixels));
        }
        return surfaces;
      },
      [&form](DrawnSurfaces& surfaces) {
        for (const ScanFusion::Side side : {ScanFusion::kScan, ScanFusion::kCt})
          form.fusion->view(side).take(std::move(surfaces.views[side]));
        return true;
      });
  return drawn;
}

void FuseDesk::close() {
  preview_.close();
  s_.fuse.fusion.reset();
}

}  // namespace typodont
