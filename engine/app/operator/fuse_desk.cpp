#include "engine/app/operator/fuse_desk.h"

#include <filesystem>
#include <string>
#include <utility>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {
constexpr int kSurfacePixels = 560;  // pixels, side of a surface's picture
}

void FuseDesk::open() {
  if (!s_.scan.review || !s_.scan.review->can_correct()) return s_.fail(s_.text("op.scan_needs_full"));
  close();
  s_.page = Page::kFuse;
  s_.say("");
  const auto ct = std::make_shared<const haptics::DenseTissue>(s_.scan.review->labels()->tissue);
  work_.make(
      [ct, file = std::filesystem::path(s_.fuse.file.data()),
       unit = static_cast<double>(s_.fuse.unit_mm) * kMillimetre](Progress& progress) {
        progress.stage("op.loading", 0, 1);
        return std::make_shared<ScanFusion>(ct, file, unit);
      },
      [this](std::shared_ptr<ScanFusion> loaded) {
        fusion_ = std::move(loaded);
        s_.fuse.fusion = fusion_.get();
        s_.fuse.changed = true;
        s_.say(s_.text("op.fuse_pick"));
        log::info("surfaces ready");
      },
      [this] { s_.page = Page::kScan; });
}

void FuseDesk::register_points() {
  if (!fusion_ || !fusion_->can_register()) return;
  work_.make(
      [fusion = fusion_](Progress& progress) {
        progress.stage("op.fuse_registering", 0, 1);
        return fusion->registered();
      },
      [this](ScanRegistration found) {
        if (!fusion_) return;
        const calibration::SurfaceRegistration fine = found.fine;
        fusion_->show(std::move(found));
        s_.fuse.changed = true;
        s_.say(s_.text("op.fuse_laid"));
        log::info("registered: {:.3f} mm median, ± {:.3f} mm", fine.median / kMillimetre,
                  fine.predicted_error / kMillimetre);
      });
}

void FuseDesk::take() {
  if (!fusion_ || !fusion_->registration()) return;
  work_.make(
      [fusion = fusion_](Progress& progress) {
        progress.stage("op.fuse_replacing", 0, 1);
        return fusion->fused(progress);
      },
      [this](haptics::Fused made) {
        if (!s_.scan.review) return;
        s_.scan.review->replace(std::move(made.tissue));
        close();
        s_.page = Page::kScan;
        s_.say(s_.text("op.fuse_done"));
        log::info("crowns replaced: {:.0f} mm²", made.report.covered_area / kSquareMillimetre);
      });
}

void FuseDesk::follow() {
  if (s_.page != Page::kFuse || !fusion_ || !(s_.fuse.changed || pictures_.empty())) return;
  destroy();
  for (const ScanFusion::Side side : {ScanFusion::kScan, ScanFusion::kCt})
    pictures_.add(fusion_->view(side).draw(kSurfacePixels));
  pictures_.list(s_.fuse.pictures);
  ++s_.fuse.drawn;
  s_.fuse.changed = false;
}

void FuseDesk::destroy() {
  s_.fuse.pictures = {};
  pictures_.clear();
}

void FuseDesk::close() {
  destroy();
  s_.fuse.fusion = nullptr;
  fusion_.reset();
}

}  // namespace typodont
