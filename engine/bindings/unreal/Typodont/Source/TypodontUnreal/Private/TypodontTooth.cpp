#include "TypodontTooth.h"

#include "Components/SceneComponent.h"
#include "Materials/MaterialInterface.h"
#include "ProceduralMeshComponent.h"
#include "TypodontBench.h"

DEFINE_LOG_CATEGORY_STATIC(LogTypodont, Log, All);

namespace {

constexpr double CentimetresPerMetre = 100;

/** A vector of W in the actor's axes, without a change of unit, and back. */
FVector ToUnreal(const double* V) {
  return FVector(V[0], -V[1], V[2]);
}
FVector ToUnreal(const float* V) {
  return FVector(V[0], -V[1], V[2]);
}

/** The reflection of y changes the signs of the rotations about x and z. */
FTransform ToUnreal(const typodont_pose& X) {
  return FTransform(FQuat(-X.q[1], X.q[2], -X.q[3], X.q[0]), ToUnreal(X.p) * CentimetresPerMetre);
}
typodont_pose ToW(const FTransform& X) {
  const FVector P = X.GetLocation() / CentimetresPerMetre;
  const FQuat Q = X.GetRotation();
  return {{P.X, -P.Y, P.Z}, {Q.W, -Q.X, Q.Y, -Q.Z}};
}

/** Pose of the actor as seen from `Frame`, whose scale changes lengths but not the rotation. */
FTransform SeenFrom(const AActor& Frame, const AActor& Actor) {
  const FTransform X = Frame.GetActorTransform();
  return FTransform(X.InverseTransformRotation(Actor.GetActorQuat()),
                    X.InverseTransformPosition(Actor.GetActorLocation()));
}

}  // namespace

ATypodontTooth::ATypodontTooth() {
  PrimaryActorTick.bCanEverTick = true;
  RootComponent = CreateDefaultSubobject<USceneComponent>(TEXT("Tissue"));
}

void ATypodontTooth::BeginPlay() {
  Super::BeginPlay();
  const typodont_pose Above = {{0, 0, 0.05}, {1, 0, 0, 0}};  // m, a pose 50 mm above the tooth
  Bench = MakeShared<FTypodontBench>();
  Error = Bench->Open(Scene, Hand ? ToW(SeenFrom(*this, *Hand)) : Above);
  if (Error.IsEmpty()) return;
  UE_LOG(LogTypodont, Error, TEXT("%s"), *Error);
  Bench.Reset();
}

void ATypodontTooth::EndPlay(const EEndPlayReason::Type Reason) {
  Bench.Reset();
  Super::EndPlay(Reason);
}

void ATypodontTooth::Tick(float DeltaSeconds) {
  Super::Tick(DeltaSeconds);
  if (!Bench) return;
  if (Hand) SendHand();
  const typodont_tick& Newest = Bench->Newest();
  Force = ToUnreal(Newest.force);
  Removed = 0;
  for (double Volume : Newest.removed) Removed += Volume * 1e9;
  if (ShownTool && Newest.struct_size != 0) {  // struct_size is 0 until the first tick
    const FTransform X = GetActorTransform(), Proxy = ToUnreal(Newest.X_WG);
    ShownTool->SetActorLocationAndRotation(X.TransformPosition(Proxy.GetLocation()),
                                           X.TransformRotation(Proxy.GetRotation()));
  }
  ShowChangedBricks();
}

bool ATypodontTooth::Undo() {
  return Bench && Bench->Undo();
}

void ATypodontTooth::SendHand() {
  typodont_sample Sample{};
  Sample.struct_size = sizeof Sample;
  Sample.X_WT = ToW(SeenFrom(*this, *Hand));
  Sample.pedal = Pedal;
  Bench->Send(Sample);
}

void ATypodontTooth::ShowChangedBricks() {
  Bench->ChangedBricks([this](const typodont_mesh_part& Part) {
    TObjectPtr<UProceduralMeshComponent>& Brick =
        Bricks.FindOrAdd(FIntVector(Part.brick[0], Part.brick[1], Part.brick[2]));
    if (!Brick) {
      Brick = NewObject<UProceduralMeshComponent>(this);
      Brick->SetupAttachment(RootComponent);
      Brick->RegisterComponent();
      Brick->SetMaterial(0, Material);
    }
    if (Part.index_count == 0) return Brick->ClearMeshSection(0);
    TArray<FVector> Positions, Normals;
    // r: number of the first tissue, g: number of the second tissue, b: fraction of the second tissue
    TArray<FColor> Tissues;
    TArray<int32> Triangles;
    Positions.Reserve(Part.vertex_count), Normals.Reserve(Part.vertex_count), Tissues.Reserve(Part.vertex_count);
    Triangles.Reserve(Part.index_count);
    for (uint32 i = 0; i < Part.vertex_count; ++i) {
      const typodont_vertex& V = Part.vertices[i];
      Positions.Add(ToUnreal(V.position) * CentimetresPerMetre);
      Normals.Add(ToUnreal(V.normal));
      Tissues.Add(FColor(V.tissue[0], V.tissue[1], V.second));
    }
    // The indices keep their order: triangles are counter-clockwise, seen from outside, in frame W and also in Unreal.
    // The reflected y axis changes only the coordinates, not the shape in space.
    for (uint32 i = 0; i < Part.index_count; ++i) Triangles.Add(static_cast<int32>(Part.indices[i]));
    Brick->CreateMeshSection(0, Positions, Triangles, Normals, TArray<FVector2D>(), Tissues, TArray<FProcMeshTangent>(),
                             false);
  });
}
