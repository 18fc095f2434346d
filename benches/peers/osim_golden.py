"""Reference values for a model of OpenSim by OpenSim itself (`pip install opensim`, 4.6).

    python benches/peers/osim_golden.py fuzz/seeds/osim/leg.osim \
        crates/sinew/tests/sinew/description/opensim.json

For each pose: the coordinates that follow no other, in the order of `coordinates`, lengths of the paths, their moment
arms about these coordinates (path by path), origins of the bodies and the centre of mass in the ground.
"""

import json
import sys

import numpy as np
import opensim as osim

POSES = 12
osim.Logger.setLevelString("error")
model = osim.Model(sys.argv[1])
model.set_assembly_accuracy(1e-14)
state = model.initSystem()
rng = np.random.default_rng(3)
every = [model.getCoordinateSet().get(k) for k in range(model.getCoordinateSet().getSize())]
free = [at for at in every if not at.isConstrained(state)]
paths = [osim.PathActuator.safeDownCast(at) for at in (model.getForceSet().get(k) for k in range(4))]
bodies = [model.getBodySet().get(k) for k in range(model.getBodySet().getSize())]
poses = []
for _ in range(POSES):
    x = [float(rng.uniform(at.getRangeMin(), at.getRangeMax())) for at in free]
    for at, value in zip(free, x):
        at.setValue(state, value, False)
    model.assemble(state)
    # What an assembly moves is read back: it knows no leader and follower.
    x = [at.getValue(state) for at in free]
    model.realizePosition(state)
    poses.append(
        {
            "x": x,
            "lengths": [path.getGeometryPath().getLength(state) for path in paths],
            "arms": [[path.getGeometryPath().computeMomentArm(state, at) for at in free] for path in paths],
            "origins": [list(body.getPositionInGround(state).to_numpy()) for body in bodies],
            "center": list(model.calcMassCenterPosition(state).to_numpy()),
        }
    )
golden = {
    "coordinates": [at.getName() for at in free],
    "paths": [path.getName() for path in paths],
    "bodies": [body.getName() for body in bodies],
    "poses": poses,
}
with open(sys.argv[2], "w") as file:
    json.dump(golden, file, indent=None, separators=(",", ":"))
    file.write("\n")
