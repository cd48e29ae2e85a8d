#include "haptics/contact/vertex/vertex_method.h"

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "haptics/contact/vertex/vertex_body.h"
#include "haptics/contact/vertex/vertex_model.h"
#include "haptics/mesh/spatial_order.h"

namespace typodont::haptics::vertex {

namespace {

class VertexMethod final : public ContactMethod {
 public:
  explicit VertexMethod(const Parameters& parameters) : parameters_(parameters) {}
  std::string_view name() const override { return kName; }
  bool draws_own_surface() const override { return true; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<VertexModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    const TissueMesh mesh = mesh::in_spatial_order(surface_mesh(tissue));
    return std::make_unique<VertexBody>(std::move(tissue), mesh, tools, parameters_);
  }

 private:
  Parameters parameters_;
};

}  // namespace

SharedContactMethod read(const std::optional<Json>& json) {
  Parameters p;
  if (json) {
    json->allow_only({"edge_mm", "as_printed", "spare_vertices"});
    if (const auto edge = json->find("edge_mm")) p.edge = edge->number(0.005, 10) * kMillimetre;
    p.as_printed = json->boolean_or("as_printed", false);
    if (const auto spare = json->find("spare_vertices")) {
      p.spare = static_cast<std::size_t>(spare->integer(0, 20'000'000));
    }
  }
  return std::make_shared<VertexMethod>(p);
}

}  // namespace typodont::haptics::vertex
