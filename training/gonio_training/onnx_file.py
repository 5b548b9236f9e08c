"""A network as one ONNX file: symbolic batch, metadata inside, no traces of where it was made."""

import os
from pathlib import Path

import onnx
import torch
from torch import nn

OPSET = 18
# The oldest file format that holds this opset, so that older ONNX Runtimes read the file.
IR_VERSION = 9


def graph(network: nn.Module, example: torch.Tensor, name: str, free: dict[int, str]) -> onnx.ModelProto:
    """The graph of a network with one input and the output `mu`. `free` names the dimensions that may vary; an example of 2
    in each, not 1, else it would be taken as fixed."""
    program = torch.onnx.export(
        network.eval(),
        (example,),
        input_names=[name],
        output_names=["mu"],
        dynamic_shapes=({place: torch.export.Dim(symbol) for place, symbol in free.items()},),
        opset_version=OPSET,
        dynamo=True,
        verbose=False,
    )
    model = program.model_proto
    model.ir_version = IR_VERSION
    model.doc_string = model.graph.doc_string = ""
    del model.metadata_props[:], model.graph.metadata_props[:]
    graph = model.graph
    for part in (*graph.node, *graph.input, *graph.output, *graph.value_info, *graph.initializer):
        part.doc_string = ""
        del part.metadata_props[:]
    return model


def write(model: onnx.ModelProto, facts: dict[str, str], path: Path) -> None:
    """Checks a model and writes it with its metadata: whole, or not at all."""
    onnx.helper.set_model_props(model, facts)
    onnx.checker.check_model(model, full_check=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    onnx.save(model, temporary)
    os.replace(temporary, path)
