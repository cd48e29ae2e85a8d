#include "engine/app/operator/scan_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "engine/app/operator/scene_works.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {
constexpr int kScanPixels = 384;  // pixels, side of a section's picture

haptics::Imported labels_of(const haptics::ScanVolume& scan, const LabelRequest& request, Progress& progress) {
  haptics::ImportOptions options = request.options;
  options.progress = [&](double done) { progress.at(done); };
  return scan.import(options);
}
}  // namespace

void ScanDesk::open() {
  close();
  s_.page = Page::kScan;
  s_.say("");
  if (s_.import.name[0] == 0) propose_name(s_);
  work_.make(
      [tooth = tooth_of(s_.import)](Progress& progress) {
        progress.stage("op.loading", 0, 1);
        const auto scan = std::make_shared<const haptics::ScanVolume>(tooth.input, tooth.options);
        auto loaded = std::make_unique<ScanReview>(scan);
        progress.at(1);
        return loaded;
      },
      [this](std::unique_ptr<ScanReview> loaded) {
        review_ = std::move(loaded);
        s_.scan.review = review_.get();
        s_.import.preset = static_cast<int>(review_->preset());
        s_.say(s_.text("op.scan_help"));
        const haptics::ScanVolume& scan = *review_->scan();
        const dvec3 size = (scan.hi() - scan.lo()) / scan.spacing();
        log::info("scan read: {}, {:.0f} x {:.0f} x {:.0f} voxels", scan.format(), size.x + 1, size.y + 1, size.z + 1);
      },
      [this] { s_.page = Page::kArchive; });
}

void ScanDesk::begin_coarse(const LabelRequest& request) {
  coarse_ = std::make_shared<Computed>(Computed{request, std::nullopt});
  job_ = std::make_unique<Job>([computed = coarse_, scan = review_->scan()](Progress& progress) {
    computed->labels = labels_of(*scan, computed->request, progress);
  });
}

void ScanDesk::begin_full(const LabelRequest& request) {
  full_ = request;
  s_.say("");
  work_.make(
      [request, scan = review_->scan()](Progress& progress) {
        progress.stage("op.scan_labelling", 0, 1);
        return labels_of(*scan, request, progress);
      },
      [this, request](haptics::Imported labels) {
        full_.reset();
        if (!review_) return;
        review_->take(request, std::move(labels));
        log::info("labels computed: full");
      },
      [this, request] {
        full_.reset();
        if (review_) review_->give_up(request);
      });
}

bool ScanDesk::look() {
  if (!review_ || s_.page != Page::kScan) return false;
  bool changed = false;
  if (job_ && job_->done()) {
    if (coarse_->labels) {
      review_->take(coarse_->request, std::move(*coarse_->labels));
      log::info("labels computed: coarse");
    } else {
      review_->give_up(coarse_->request);
      try {
        std::rethrow_exception(job_->failure());
      } catch (const Cancelled&) {
      } catch (const std::exception& e) {
        s_.fail(e.what());
      }
    }
    job_.reset();
    coarse_.reset();
    changed = true;
  }
  const std::optional<LabelRequest> wanted = review_->request();
  if (full_ && wanted && wanted->revision != full_->revision) work_.cancel();
  if (!wanted || job_) return changed;
  if (wanted->detail == LabelDetail::kCoarse)
    begin_coarse(*wanted);
  else if (!work_.under_way())
    begin_full(*wanted);
  return changed;
}

void ScanDesk::follow() {
  if (s_.page != Page::kScan || !review_ || (drawn_ == review_->changes() && !pictures_.empty())) return;
  destroy();
  s_.scan.planes = review_->planes();
  for (const SectionPlane& plane : s_.scan.planes) pictures_.add(review_->picture(plane, kScanPixels));
  pictures_.list(s_.scan.pictures);
  drawn_ = review_->changes();
  ++s_.scan.drawn;
}

void ScanDesk::import(Choices& choices) {
  if (review_) import_reviewed(s_, work_, choices, *review_);
}

void ScanDesk::destroy() {
  s_.scan.pictures = {};
  pictures_.clear();
}

void ScanDesk::close() {
  destroy();
  job_.reset();
  coarse_.reset();
  full_.reset();
  s_.scan = {};
  review_.reset();
}

}  // namespace typodont
