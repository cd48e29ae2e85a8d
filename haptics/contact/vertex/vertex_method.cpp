#include "haptics/contact/vertex/vertex_method.h"

#include "engine/base/error.h"
#include "engine/base/keys.h"
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

SharedContactMethod read(Keys& keys) {
  Parameters p;
  keys("edge_mm", p.edge, {0.005, 10, kMillimetre},
       "edge length of carved triangles; default: one sixth of the head's radius");
  keys("as_printed", p.as_printed, "true: the rules of the paper as published");
  keys("spare_vertices", p.spare, {0, 20'000'000}, "number of vertices that cuts may add");
  return std::make_shared<VertexMethod>(p);
}

}  // namespace typodont::haptics::vertex
