"""Compiles the schemas of a recording into schemas.binpb, a FileDescriptorSet.

    pip install grpcio-tools foxglove-schemas-protobuf && python make.py

The schemas `foxglove.*` are those of Foxglove (MIT), `google.protobuf.*` those of Protocol Buffers (BSD-3-Clause).
"""

import pathlib
import tempfile

from foxglove_schemas_protobuf import FrameTransforms_pb2, Log_pb2, SceneUpdate_pb2
from google.protobuf import descriptor_pb2
from grpc_tools import protoc

here = pathlib.Path(__file__).parent
files = {}


def add(file):
    for dependency in file.dependencies:
        add(dependency)
    if file.name not in files:
        files[file.name] = descriptor_pb2.FileDescriptorProto()
        file.CopyToProto(files[file.name])


for module in (FrameTransforms_pb2, SceneUpdate_pb2, Log_pb2):
    add(module.DESCRIPTOR)
with tempfile.TemporaryDirectory() as folder:
    out = pathlib.Path(folder) / "record.binpb"
    include = pathlib.Path(protoc.__file__).parent / "_proto"
    arguments = ["protoc", f"-I{here}", f"-I{include}", f"--descriptor_set_out={out}", "sinew/record.proto"]
    if protoc.main(arguments) != 0:
        raise SystemExit("sinew/record.proto does not compile")
    own = descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes())
together = descriptor_pb2.FileDescriptorSet(file=[*files.values(), *own.file])
(here / "schemas.binpb").write_bytes(together.SerializeToString(deterministic=True))
