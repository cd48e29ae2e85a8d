// Runs the actor of engine/bindings/unreal with unreal_declarations.h as Unreal would do. It drills a ball that is
// shown ten times larger, checks the meshes of the bricks, and undoes the stroke. Prints its results; returns 1 at the
// first error.
#include <cstdlib>

#include "TypodontTooth.h"
#include "unreal_declarations.h"

static void require(bool holds, const char* claim) {
  if (holds) return;
  std::printf("not so: %s\n", claim);
  std::exit(1);
}

static UProceduralMeshComponent* brick_of(const std::unique_ptr<UObject>& object) {
  return dynamic_cast<UProceduralMeshComponent*>(object.get());
}

static int changes_of_all_bricks() {
  int changes = 0;
  for (const auto& object : all_objects())
    if (const auto* const brick = brick_of(object)) changes += brick->changes;
  return changes;
}

/// Checks that every vertex lies on the ball of 3 mm, and that every triangle faces outwards in Unreal's left-handed
/// axes. Returns the number of bricks.
static int checked_bricks(bool whole) {
  int bricks = 0;
  for (const auto& object : all_objects()) {
    const UProceduralMeshComponent* const brick = brick_of(object);
    if (!brick || brick->triangles.Num() == 0) continue;
    ++bricks;
    require(brick->shown(), "each brick is attached and registered");
    require(brick->normals.Num() == brick->positions.Num() && brick->colours.Num() == brick->positions.Num(),
            "each vertex has a normal and a colour");
    for (int32 i = 0; i < brick->positions.Num(); ++i)
      require(brick->positions[i].Size() < 0.31 && (!whole || brick->positions[i].Size() > 0.29), "radius in cm");
    for (int32 i = 0; i < brick->triangles.Num(); i += 3) {
      const auto p = [&](int32 k) { return brick->positions[brick->triangles[i + k]]; };
      const FVector n = FVector::CrossProduct(p(1) - p(0), p(2) - p(0));
      require(!whole || FVector::DotProduct(n, p(0)) <= 0, "triangles are counter-clockwise as seen from outside");
    }
  }
  return bricks;
}

constexpr double kX = 0.04, kY = -0.06;  // cm, place of the hand in the actor's frame

/// Returns the mean position of the vertices that lie clearly inside the former ball.
static FVector pit() {
  FVector sum;
  int count = 0;
  for (const auto& object : all_objects()) {
    const UProceduralMeshComponent* const brick = brick_of(object);
    for (int32 i = 0; brick && i < brick->positions.Num(); ++i) {
      if (brick->positions[i].Size() > 0.298) continue;
      sum = sum + brick->positions[i];
      ++count;
    }
  }
  require(count > 0, "the pit has vertices");
  return sum / count;
}

int main() {
  auto* const broken = NewObject<ATypodontTooth>();
  broken->Scene = TEXT("no such scene");
  broken->BeginPlay();
  broken->Tick(0);
  require(!broken->Error.IsEmpty(), "an unknown scene gives an error text");
  broken->EndPlay(EEndPlayReason::Quit);

  auto* const tooth = NewObject<ATypodontTooth>();
  auto* const hand = NewObject<AActor>();
  auto* const tool = NewObject<AActor>();
  tooth->Scene = TEXT(
      "{\"tissue\": {\"voxel_mm\": 0.1, \"solids\": [{\"tissue\": \"enamel\", \"solid\": {\"sphere\": {\"radius_mm\": "
      "3}}}]},"
      " \"tool\": \"round_012\", \"spindle_krpm\": 300}");
  // The actor is ten times as large, and lies on its side: its z axis is the level's x axis.
  const double half = std::sqrt(0.5);
  tooth->SetActorTransform(FTransform(FQuat(0, half, 0, half), FVector(50, 0, 0), 10));
  tooth->Hand = hand;
  tooth->ShownTool = tool;
  tooth->Pedal = 1;
  double z = 0.4;  // cm, in the actor's frame
  const auto frame = [&] {
    const FTransform X = tooth->GetActorTransform();
    hand->SetActorTransform(FTransform(X.TransformRotation(FQuat()), X.TransformPosition(FVector(kX, kY, z))));
    tooth->Tick(1.0f / 60);
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
  };

  frame();
  tooth->BeginPlay();
  require(tooth->Error.IsEmpty(), "the scene opens");
  while (changes_of_all_bricks() == 0) frame();
  const int bricks = checked_bricks(true), first = changes_of_all_bricks();
  require(first == bricks, "the first frame makes each brick once");
  require(tooth->Force.Size() == 0 && tooth->Removed == 0, "no force away from the tissue");

  double largest = 0;  // N
  while (z > 0.26 && (tooth->Removed < 0.01 || largest < 0.1)) {
    z -= 25e-4;
    frame();
    largest = std::max(largest, tooth->Force.Z);
  }
  require(largest > 0.1, "the force points out of the tissue, along the actor's z axis");
  const FVector shown = tooth->GetActorTransform().InverseTransformPosition(tool->GetActorLocation());
  require(shown.Z >= z - 1e-9 && std::abs(shown.X - kX) < 0.02 && std::abs(shown.Y - kY) < 0.02,
          "the tool is shown at the hand, and not deeper than it");
  z = std::nan("");  // no force, and no crash
  while (tooth->Force.Z != 0) frame();
  z = 0.26;
  while (tooth->Force.Z == 0) frame();
  while (z < 0.4) z += 25e-4, frame();
  const double removed = tooth->Removed;
  for (int i = 0; i < 10; ++i) frame();
  const int drilled = changes_of_all_bricks() - first;
  checked_bricks(false);
  int changed = 0;
  for (const auto& object : all_objects())
    if (const auto* const brick = brick_of(object)) changed += brick->changes > 1;
  require(changed > 0 && changed < bricks / 2, "drilling changes bricks, and leaves the others as they are");
  require(std::abs(pit().X - kX) < 0.02 && std::abs(pit().Y - kY) < 0.02, "the pit is where the hand was");
  require(tooth->Undo(), "the stroke is undone");
  while (changes_of_all_bricks() == first + drilled) frame();
  checked_bricks(true);
  tooth->EndPlay(EEndPlayReason::Quit);
  tooth->Tick(0);
  std::printf("%d bricks, of which %d changed, %.3f mm3, %.3f N at most\n", bricks, changed, removed, largest);
  return 0;
}
