"""A network as one ONNX file: symbolic batch, metadata inside, no traces of where it was made."""

import os
from pathlib import Path

import onnx
import torch
from torch import nn

OPSET = 18
# The oldest file format that holds this opset, so that older ONNX Runtimes read the file.
IR_VERSION = 9


def graph(network: nn.Module, inputs: dict[str, tuple[torch.Tensor, dict[int, str]]]) -> onnx.ModelProto:
    """The graph of a network with these inputs, in order, and the output `mu`. An input is an example and the names of the
    dimensions that may vary; the example has 2 in each, not 1, else it would be taken as fixed."""
    symbols = {symbol for _, free in inputs.values() for symbol in free.values()}
    dims = {symbol: torch.export.Dim(symbol) for symbol in symbols}
    program = torch.onnx.export(
        network.eval(),
        tuple(example for example, _ in inputs.values()),
        input_names=list(inputs),
        output_names=["mu"],
        dynamic_shapes=tuple({place: dims[symbol] for place, symbol in free.items()} for _, free in inputs.values()),
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
