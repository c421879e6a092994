"""All that the fused method assumes, in one value: a test or a user can change one number of it.

Each field states its unit and its origin. What an installation may want to set is in [controller.fused] instead.
"""

from dataclasses import dataclass, field

from stillarm.controller.estimation.fused.assumptions.date_assumptions import (
    ArrivalAssumptions,
    CountAssumptions,
    DateAssumptions,
    EvidenceAssumptions,
)
from stillarm.controller.estimation.fused.assumptions.fault_assumptions import (
    ConsistencyAssumptions,
    DateWatchAssumptions,
    FreshStartAssumptions,
    OutlierAssumptions,
)
from stillarm.controller.estimation.fused.assumptions.filter_assumptions import (
    ScaleAssumptions,
    StartAssumptions,
    UpdateAssumptions,
    WalkAssumptions,
)
from stillarm.controller.estimation.fused.assumptions.force_assumptions import (
    HeldForceAssumptions,
    RandomForceAssumptions,
)
from stillarm.controller.estimation.fused.assumptions.sensor_assumptions import (
    AgainstImagesAssumptions,
    BlockAssumptions,
    ImpactDetectorAssumptions,
    ImpactMeterAssumptions,
    JointAssumptions,
    SampleAssumptions,
)


@dataclass(frozen=True, slots=True)
class Assumptions:
    """All assumptions, grouped by subject; docs/fused.md says where each is used."""

    blocks: BlockAssumptions = field(default_factory=BlockAssumptions)
    samples: SampleAssumptions = field(default_factory=SampleAssumptions)
    against_images: AgainstImagesAssumptions = field(default_factory=AgainstImagesAssumptions)
    impact_detector: ImpactDetectorAssumptions = field(default_factory=ImpactDetectorAssumptions)
    impact_meter: ImpactMeterAssumptions = field(default_factory=ImpactMeterAssumptions)
    joint: JointAssumptions = field(default_factory=JointAssumptions)
    count: CountAssumptions = field(default_factory=CountAssumptions)
    arrivals: ArrivalAssumptions = field(default_factory=ArrivalAssumptions)
    dates: DateAssumptions = field(default_factory=DateAssumptions)
    evidence: EvidenceAssumptions = field(default_factory=EvidenceAssumptions)
    start: StartAssumptions = field(default_factory=StartAssumptions)
    update: UpdateAssumptions = field(default_factory=UpdateAssumptions)
    walks: WalkAssumptions = field(default_factory=WalkAssumptions)
    scale: ScaleAssumptions = field(default_factory=ScaleAssumptions)
    random_force: RandomForceAssumptions = field(default_factory=RandomForceAssumptions)
    held_force: HeldForceAssumptions = field(default_factory=HeldForceAssumptions)
    outlier: OutlierAssumptions = field(default_factory=OutlierAssumptions)
    consistency: ConsistencyAssumptions = field(default_factory=ConsistencyAssumptions)
    date_watch: DateWatchAssumptions = field(default_factory=DateWatchAssumptions)
    fresh_start: FreshStartAssumptions = field(default_factory=FreshStartAssumptions)


ASSUMPTIONS = Assumptions()
